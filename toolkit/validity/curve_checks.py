"""Time curves that a run does not see, that swing beyond their values, or that change nothing before its end.

Whether the times of a run saw what a change of a curve's times does: a jump that is moved within a step changes nothing that they see.

The derivative of a curve by its start is -f', which is a pulse where the curve is a jump. Values may be right to the step while no run sees
this pulse, so that runs with other steps agree about a derivative of zero.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from toolkit.components.curves.curve import Curve, CurvePart
from toolkit.components.curves.table import Table
from toolkit.foundation.units import LABELLED
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.scene.design_variables import number_measure
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.quantities import STEP, curves_of
from toolkit.system.solution import Solution

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Scalar

LOST_VARIATION = 0.2
"""Part of a curve's variation that may lie between the times of a run. A sine loses 0.21 with four samples in a period; runs with twice the
step then see two, and the comparison with them tells. With fewer, or pulses between two times, all runs may see the same and agree."""
LOST_IN_ONE_STEP = 0.05
"""Part that a single step may lose in which a whole piece of the curve lies; a load that is switched on within a step loses half of it."""
LEVEL_PART = 0.05
"""Part of a load's level that counts as its variation: a ripple of less than a hundredth of it changes little."""
MOST_EXAMINED_STEPS, LEAST_STEPS_OF_PIECE = 50_000, 4
"""Largest number of steps that are examined, shared out among the pieces of the curve, and the least number of a piece."""
SAMPLES, LEAST_SAMPLES, MOST_SAMPLES = 4096, 8, 512
"""Least number of samples of a curve, and the least and largest number in a step: an error of a few percent at most."""
SHARED_LOSS = 0.05
"""Loss of a piece of a curve, relative to that of the worst piece, above which it counts among the pieces that lose it."""
SAMPLES_AT_ONCE = 1 << 16
"""Number of samples that are evaluated at a time."""
GOLDEN = (5**0.5 - 1) / 2
"""Golden section, whose multiples without their whole parts are spread evenly, and in step with no period."""


class CurveOverTime(Protocol):
    """A curve over time, or its derivative by one of its numbers."""

    @property
    def is_constant(self) -> bool:
        """Whether the curve has one value at all times, as in `Curve`."""

    def corners(self) -> tuple[Scalar, ...]:
        """Times of the curve's corners, as in `Curve`."""

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """Values at times (n_t,), as in `Curve`; the first column counts."""


@dataclass(frozen=True)
class Loss:
    """Part of a curve that a run did not see.

    Attributes
    ----------
    part
        Lost part of the curve's variation.
    in_one
        Part that a single step loses in which a whole piece of the curve may hide, signed: of the impulse of a load.
    time
        Where most of it was lost.
    shortest
        Shortest of the pieces that lose it, between two corners of the curve.
    corners
        Corners of these pieces within the run.
    """

    part: float
    in_one: float
    time: float
    shortest: float
    corners: np.ndarray


@check("load-curve", (MOTION,))
def unseen_curves(solution: Solution) -> Iterator[Caution]:
    """A load's curve changes between the times of the run.

    Limit: 20 % of its variation, 5 % within one step.
    Fix: a smaller `solver.step`, or `solver.times` where it changes.
    """
    for (group, name), curve in curves_of(solution.system.scene):
        loss = loss_of(curve, solution.whole_run, has_zero=group == "loads")
        if loss is not None and (loss.part > LOST_VARIATION or loss.in_one > LOST_IN_ONE_STEP):
            how_much = f"{loss.part:.0%} of its variation (limit {LOST_VARIATION:.0%})"
            if loss.part <= LOST_VARIATION:
                how_much = f"{loss.in_one:.0%} of its variation within one step (limit {LOST_IN_ONE_STEP:.0%})"
            yield unseen_curves.caution(
                f"{group}.{name}.curve changes between the times of the run: the straight lines between them miss it by {how_much}, most "
                f"near t = {loss.time:.4g}. Runs with other steps may miss the same and agree. {_advice(curve, loss)}",
            )


def loss_of(curve: CurveOverTime, times: np.ndarray, has_zero: bool = True) -> Loss | None:
    """Loss of a curve by the straight lines between its values at the times of a run; None if it does not vary.

    The area between curve and lines, as a part of the area between the curve and the level that it has at the start, at the end or in the
    mean, whichever leaves least: what is constant may be in balance, so that only what varies moves anything. The area counts without
    sign: a whole period in a step loses no impulse, but all that it does. A load that begins at zero does all that it does by its level,
    also if it reaches it within the first step, and a small part of the level always counts; a driver is at rest where it begins.
    """
    if curve.is_constant:
        return None
    pieces = _pieces(curve, float(times[0]), float(times[-1]))
    piece, step, weight, shift = _picked(pieces, times)
    count = min(max(-(-SAMPLES // len(step)), LEAST_SAMPLES), MOST_SAMPLES)
    blocks = [slice(n, n + SAMPLES_AT_ONCE // count) for n in range(0, len(step), SAMPLES_AT_ONCE // count)]
    samples = [_samples(curve, times, pieces[piece[block]], step[block], count, shift[block]) for block in blocks]
    f, signed, missed, length = (np.concatenate(parts) for parts in zip(*samples, strict=True))
    variation = _variation(f, weight * length, _values(curve, times[[0, -1]]), has_zero)
    if not variation > 0:
        return None
    hiding = np.isin(step, step[(np.bincount(piece) == 1)[piece]])
    of_piece = np.bincount(piece, weight * missed, len(pieces))
    worst = int(step[np.argmax(missed)])
    losing = pieces[of_piece >= SHARED_LOSS * of_piece.max()]
    return Loss(
        part=float(weight @ missed / variation),
        in_one=float(np.abs(np.bincount(np.cumsum(np.diff(step, prepend=0) > 0), signed * hiding)).max() / variation),
        time=float(times[worst : worst + 2].mean()),
        shortest=float(np.diff(losing).min()),
        corners=np.setdiff1d(losing, times[[0, -1]]),
    )


def _variation(f: np.ndarray, lengths: np.ndarray, ends: np.ndarray, has_zero: bool) -> float:
    """Area between a curve and its idle level, from samples (n, count) within pieces of time of these lengths (n,)."""
    areas = np.repeat(lengths / f.shape[1], f.shape[1])
    mean = float(areas @ f.ravel()) / float(areas.sum())
    rest = 0.0 if has_zero else float(ends[0])
    *around, level = (float(areas @ np.abs(f.ravel() - each)) for each in (*ends, mean, rest))
    return max(min(around), LEVEL_PART * level, level - abs(float(ends[0]) - rest) * float(areas.sum()))


def _values(curve: CurveOverTime, times: np.ndarray) -> np.ndarray:
    """Values of a curve at times of any shape."""
    return np.real(curve.evaluate(times.ravel())[:, 0]).reshape(times.shape)


def _pieces(curve: CurveOverTime, start: float, end: float) -> np.ndarray:
    """Beginning and end of the pieces of a run between corners of the curve, (n, 2)."""
    corners = np.unique(np.real(np.array([start, *curve.corners(), end])))
    corners = corners[(corners >= start) & (corners <= end)]
    return np.stack([corners[:-1], corners[1:]], axis=1)


def _picked(pieces: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Pieces and steps that meet and are examined, for how many each stands, and where between two others its samples are.

    The first and the last step of a piece stand for themselves, because a corner may lie in them; of many others one is taken from each
    of equal groups, at places that change from group to group, as those of the samples do.
    """
    first = np.searchsorted(times, pieces[:, 0], "right") - 1
    there = np.searchsorted(times, pieces[:, 1], "left") - first
    taken = np.minimum(there, max(MOST_EXAMINED_STEPS // len(pieces), LEAST_STEPS_OF_PIECE))
    piece = np.repeat(np.arange(len(pieces)), taken)
    place = np.arange(len(piece)) - np.repeat(np.cumsum(taken) - taken, taken)
    ratio = (np.maximum(there - 2, 1) / np.maximum(taken - 2, 1))[piece]
    inner, shift = (place > 0) & (place < taken[piece] - 1), GOLDEN * place % 1
    chosen = 1 + np.floor((place - 1 + shift) * ratio).astype(int)
    step = first[piece] + np.where(inner, chosen, np.where(place > 0, there[piece] - 1, 0))
    return piece, step, np.where(inner, ratio, 1.0), np.where(inner, shift, 0.5)


def _samples(
    curve: CurveOverTime, times: np.ndarray, pieces: np.ndarray, step: np.ndarray, count: int, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Values (n, count) of the curve where steps and pieces meet, the areas (n,) between it and lines, signed and not, and lengths (n,)."""
    begin, end = times[step], times[step + 1]
    low, high = np.maximum(begin, pieces[:, 0]), np.minimum(end, pieces[:, 1])
    t = low[:, None] + (high - low)[:, None] * (np.arange(count) + shift[:, None]) / count
    f, ends = _values(curve, t), _values(curve, np.stack([begin, end], axis=1))
    line = ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * (t - begin[:, None]) / (end - begin)[:, None]
    return f, (f - line).mean(axis=1) * (high - low), np.abs(f - line).mean(axis=1) * (high - low), high - low


def _advice(curve: Curve, loss: Loss) -> str:
    """Sentence on steps that would see the curve."""
    period = min(curve.periods(), default=np.inf)
    what, shortest = ("period", period) if period < loss.shortest else ("piece", loss.shortest)
    told = f"Fix: solver.step = {shortest / 10:.2g}, a tenth of its shortest {what}"
    if what == "period" or not len(loss.corners):
        return f"{told}."
    named = ", ".join(f"{corner:.6g}" for corner in loss.corners[:6]) + ", ..." * (len(loss.corners) > 6)
    return f"{told}, or solver.times with its corners ({named}) and times between them."


HIDDEN_CHANGE = 0.5
"""Part of a curve's change that may lie between the times of a run: with less, runs with other steps see another part of it."""
TIME = LABELLED["time"]


@dataclass(frozen=True)
class Slope:
    """Derivative of a curve by a variable that is in its numbers as a complex step."""

    curve: Curve
    is_constant = False

    def corners(self) -> tuple[float, ...]:
        """Times of the curve's corners: where its slope jumps, its derivative by the variable jumps."""
        return tuple(np.real(self.curve.corners()))

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """Derivatives of f, f', f'' at the times, (n_t, 3)."""
        return np.imag(self.curve.evaluate(time)) / STEP


@check("gradient-curve")
def unseen_moves(solution: Solution, variables: Collection[str]) -> Iterator[Caution]:
    """Steps do not see when a curve changes whose times a variable of the design moves.

    Limit: 50 % of what the variable does to the curve.
    Fix: a curve that changes over several steps, or `solver.times` there.
    """
    scene = solution.system.scene
    for name in variables:
        moved = _moved(scene, name)
        for item, curve in curves_of(moved) if moved is not None else ():
            if curve == dict(curves_of(scene))[item]:
                continue
            loss = loss_of(Slope(curve), solution.whole_run)
            if loss is not None and loss.part > HIDDEN_CHANGE:
                yield unseen_moves.caution(
                    f"derivatives by {name} miss {min(loss.part, 1):.0%} (limit {HIDDEN_CHANGE:.0%}) of what it does to "
                    f"{'.'.join(item)}.curve, most near t = {loss.time:.4g}. The curve changes faster there than steps are short. "
                    "Runs with other steps may miss "
                    f"the same and agree. Fix: a curve that changes over several steps, or steps of {loss.shortest / 10:.2g} there "
                    "(solver.times).",
                )


def _moved(scene: ResolvedScene, variable: str) -> ResolvedScene | None:
    """The scene with a complex step in the times that a variable drives; None if it drives none."""
    moved = None
    for path, factor in zip(scene.paths_of(variable), scene.factors_of(variable), strict=True):
        if path.split(".")[0] in ("joints", "loads") and number_measure(scene, path).dimension == TIME:
            moved = (moved or scene).with_number(path, scene.number(path) + 1j * STEP * factor)
    return moved


@check("idle-curve", (MOTION,))
def idle_curves(solution: Solution) -> Iterator[Caution]:
    """A curve begins to change after the run has ended.

    Limit: any.
    Fix: a later `solver.end_time`.
    """
    end = float(solution.times[-1])
    for (group, name), curve in curves_of(solution.system.scene):
        part = next((each for each in _parts(curve) if each.begin >= end), None)
        where = f"{group}.{name}.curve"
        if part is not None:
            yield _idle(f"{where}.{part.path} takes over at t = {part.begin:g}", end)
        elif not curve.is_constant and (begin := _first_change(curve, solution.whole_run)) is not None:
            yield _idle(f"{where} keeps its first value until t = {begin:g}", end)


def _parts(curve: Curve, path: str = "", shift: float = 0.0) -> Iterator[CurvePart]:
    """Curves within a curve at any depth, with the times of the whole."""
    for part in curve.parts():
        inner = part._replace(path=path + part.path, begin=part.begin + shift)
        yield inner
        yield from _parts(part.curve, f"{inner.path}.", shift + float(np.real(part.shift)))


def _first_change(curve: Curve, times: np.ndarray) -> float | None:
    """The first corner of a curve that has one value over all the run, if that corner lies at its end or later."""
    corners = [float(corner) for corner in np.real(curve.corners()) if corner >= times[-1]]
    values = np.real(curve.evaluate(times)[:, 0])
    return min(corners) if corners and np.all(values == values[0]) else None


def _idle(what: str, end: float) -> Caution:
    return idle_curves.caution(f"{what}, and the run ends at t = {end:g}: it has no effect. {idle_curves.fix}", doubt=False)


OVERSHOOT = 0.1
"""Part of the range of a table's values by which its cubic may leave it: a sine by eight rows in a period leaves it by 4 %."""

DOUBTED_OVERSHOOT = 0.5
"""The same that nobody means: a pulse of a few close rows in a long table may swing to a hundred thousand times its height before it."""


@check("curve-overshoot", (MOTION,))
def overshooting_tables(solution: Solution) -> Iterator[Caution]:
    """A cubic table swings beyond its values between its rows.

    Limit: 10 % of the range of its values; a doubt from 50 % on.
    Fix: `interpolation = "monotone"` or `"linear"`, or more rows.
    """
    times = solution.whole_run
    for (group, name), curve in curves_of(solution.system.scene):
        for path, table, start, end in _cubics(f"{group}.{name}.curve", curve, float(times[0]), float(times[-1])):
            time, value = _furthest(table, start, end)
            low, high = np.real(min(table.values, key=np.real)), np.real(max(table.values, key=np.real))
            beyond = max(value - high, low - value)
            if beyond > OVERSHOOT * (high - low) > 0:
                yield overshooting_tables.caution(
                    f"{path} swings beyond its values, which are from {low:g} to {high:g}. It reaches {value:.4g} at t = {time:.4g}, "
                    f"{beyond / (high - low):.3g} times their range outside: it is a cubic through all of them. "
                    f'Fix: {path}.interpolation = "monotone" or "linear", more rows where it is steep, or smooth steps.',
                    doubt=bool(beyond > DOUBTED_OVERSHOOT * (high - low)),
                )


def _cubics(path: str, curve: Curve, start: float, end: float) -> Iterator[tuple[str, Table, float, float]]:
    """Cubic tables of a curve, their paths, and when they count, in their own time."""
    for part in curve.parts():
        low, high = max(start, part.begin), min(end, part.end)
        if low < high:
            shift = float(np.real(part.shift))
            yield from _cubics(f"{path}.{part.path}", part.curve, low - shift, high - shift)
    if isinstance(curve, Table) and curve.interpolation == "cubic":
        yield path, curve, start, end


def _furthest(table: Table, start: float, end: float) -> tuple[float, float]:
    """Time of a run, and value there, at which a table is furthest from the middle of its values."""
    times = np.concatenate([[start, end], _turns(np.real(np.array(table.times)), table)])
    times = times[(times >= start) & (times <= end)]
    f, values = np.real(table.evaluate(times)[:, 0]), np.real(np.array(table.values))
    worst = int(np.argmax(np.abs(f - (values.min() + values.max()) / 2)))
    return float(times[worst]), float(f[worst])


def _turns(corners: np.ndarray, table: Table) -> np.ndarray:
    """Times between corners at which the slope, a parabola through its values at both and half way, is zero."""
    low, width = corners[:-1], np.diff(corners)
    left, middle, right = (np.real(table.evaluate(low + part * width)[:, 1]) for part in (0.0, 0.5, 1.0))
    square, linear = 2 * (left - 2 * middle + right), 4 * middle - 3 * left - right
    with np.errstate(divide="ignore", invalid="ignore"):  # a slope without zero has none
        sum_ = -(linear + np.copysign(np.sqrt(linear**2 - 4 * square * left), linear)) / 2
        parts = np.stack([sum_ / square, left / sum_])
    return (low + parts * width)[(parts > 0) & (parts < 1)]
