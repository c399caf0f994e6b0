"""Largest and smallest values over time, their smooth maximum, and what makes such a value or its derivative uncertain.

Largest and least values over time that occur at several instants with other derivatives: there the derivative jumps.

A swing that comes back to the same height, or a load that repeats, has peaks of one height. The largest value is the same by each; by a
variable it follows the peak that rises fastest, to the other side the one that falls slowest.

Peaks between the steps of a run, which a largest value over all steps does not see, however well other steps agree with it.

A wheel with five steps in a turn is seen at five places, with twice as long steps at the same five. Four values in a row tell: a parabola
through three of them has its vertex between the inner two, and so has the one through the other three. The lower vertex counts, so that
a jump, which bends one of them alone, is no peak.

A beam held alike at both ends is stressed alike there. The thickness of one half then moves the stress of its own end and not that of the
other, and the largest of both follows whichever grows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np

from toolkit.description.description import OF_OWNER, Positive, Quantity
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import RESULT_TIE_BAND, first_largest
from toolkit.foundation.verdict import Caution
from toolkit.responses.local_stress import stress_places
from toolkit.responses.over_time import OfTable, over_all_steps
from toolkit.responses.response import slope_at
from toolkit.responses.stress import KSStress, MaxStress, kreisselmeier_steinhauser
from toolkit.system.solution import Solution

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Scalar


class Extreme(OfTable):
    """Base of extremes over time.

    Attributes
    ----------
    of
        Table of a response at one time, with its `type` and keys.
    measure
        Signed: the value itself counts. Absolute: its magnitude.
    """

    measure: Literal["signed", "absolute"] = "signed"

    def of_slopes(self, _size: float, slopes: np.ndarray, _duration: float) -> np.ndarray:
        """Zeros: an extreme's derivative is that of one instant, and does not swing with the derivatives at the others."""
        return np.zeros_like(slopes)

    def considered(self, values: np.ndarray) -> np.ndarray:
        """Values that count (n_t,), or (2 n_t,) with the opposite sign too."""
        return np.concatenate([values, -values]) if self.measure == "absolute" else values

    def folded(self, weights: np.ndarray) -> np.ndarray:
        """Weights of the values (n_t,) from those of the considered ones."""
        half = len(weights) // 2
        return weights[:half] - weights[half:] if self.measure == "absolute" else weights


class TimeMax(Extreme):
    """Largest value of a quantity at the steps of a run; its derivative is that of the first step where it occurs. `of` is its table."""

    kind = "time-max"

    def reduced(self, values: np.ndarray, _shares: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Largest value of all steps, and its derivatives by the values: nonzero at the first step where it occurs."""
        value, weights = _first(self.considered(values))
        return value, self.folded(weights)

    def combined(self, values: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Largest of the windows' values, and its derivatives by them: one for the first largest window, else zero."""
        return _first(values)


class TimeMin(OfTable):
    """Smallest value of a quantity at the steps of a run; its derivative is that of the first step where it occurs. `of` is its table."""

    kind = "time-min"

    def of_slopes(self, _size: float, slopes: np.ndarray, _duration: float) -> np.ndarray:
        """Zeros: an extreme's derivative is that of one instant, and does not swing with the derivatives at the others."""
        return np.zeros_like(slopes)

    def reduced(self, values: np.ndarray, _shares: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Smallest value of all steps, and its derivatives by the values: nonzero at the first step where it occurs."""
        return self.combined(values)

    def combined(self, values: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Smallest of the windows' values, and its derivatives by them: one for the first smallest window, else zero."""
        value, weights = _first(-values)
        return -value, weights


class TimeKS(Extreme):
    """Smooth maximum (Kreisselmeier-Steinhauser) of a quantity at the steps of a run: at most ln(n) / aggregation above the largest of its
    n values, never below. It has no limit for ever smaller steps. `of` is its table.

    Attributes
    ----------
    of
        Table of a response at one time, with its `type` and keys.
    aggregation
        Parameter rho, in 1/unit of the quantity, or a pure number with `reference`.
    reference
        Value that all values are divided by first; the result is a value again.
    """

    kind = "time-ks"

    aggregation: Annotated[Positive, OF_OWNER]
    reference: Annotated[Positive | None, OF_OWNER] = None

    def quantity_of(self, field: str) -> Quantity | None:
        """Quantity of a field: the aggregation's depends on whether there is a reference, which has the quantity's own unit."""
        if field == "aggregation":
            return Quantity("none") if self.reference is not None else self._of_power(-1)
        return self._of_power(1) if field == "reference" else super().quantity_of(field)

    def _of_power(self, exponent: int) -> Quantity:
        words = [f"{name}^{power}" for name, power in self.source.physical_dimension.power(exponent)._asdict().items() if power]
        return Quantity(" ".join(words) or "none")

    @property
    def sharpness(self) -> float:
        """Aggregation parameter in 1/unit of the quantity."""
        return self.aggregation / (1.0 if self.reference is None else self.reference)

    def reduced(self, values: np.ndarray, _shares: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Smooth maximum of the values, and its derivatives by them: softmax weights."""
        value, weights = kreisselmeier_steinhauser(self.considered(values), self.sharpness)
        return value, self.folded(weights)

    def combined(self, values: np.ndarray) -> tuple[Scalar, np.ndarray]:
        """Smooth maximum of the windows' own smooth maxima, and its derivatives by them."""
        return kreisselmeier_steinhauser(values, self.sharpness)


def _first(values: np.ndarray) -> tuple[Scalar, np.ndarray]:
    """The largest value, of equal ones the first, and weight one at its place."""
    place = first_largest(np.real(values), RESULT_TIE_BAND)
    return values[place], (np.arange(len(values)) == place).astype(float)


TIED_PEAKS = 1e-6
"""Part of the largest magnitude by which peaks may differ and still be one value: what steps leave of peaks that are equal, about."""
DERIVATIVE_JUMP = 0.1
"""Part of the larger derivative by which derivatives of tied peaks may differ without a word, as of other errors of gradients."""


def tied_extremes(solution: Solution) -> Iterator[Caution]:
    """Doubt for every derivative of an extreme over time that jumps, where the solution holds derivatives."""
    if solution.run_times is not None or not solution.dq.shape[2] or not solution.steps:
        return
    for name, response in solution.system.scene.responses.items():
        if isinstance(response, TimeMax | TimeMin):
            yield from _tied_extreme(name, response, solution)


def _tied_extreme(name: str, response: TimeMax | TimeMin, solution: Solution) -> Iterator[Caution]:
    look, values = response.source.instants(solution), np.real(over_all_steps(response.source, solution))
    absolute = isinstance(response, TimeMax) and response.measure == "absolute"
    height = np.abs(values) if absolute else -values if isinstance(response, TimeMin) else values
    tied = tied_peaks(height)
    if len(tied) < 2:
        return
    signs = np.sign(values[tied]) if absolute else np.ones(len(tied))
    slopes = np.array([sign * slope_at(look(int(step)), solution, int(step)) for sign, step in zip(signs, tied, strict=True)])
    jumps = np.ptp(slopes, axis=0) > DERIVATIVE_JUMP * np.abs(slopes).max(axis=0)
    for x, variable in enumerate(solution.system.design.names):
        if jumps[x]:
            first, other = (int(k) for k in (0, np.argmax(np.abs(slopes[:, x] - slopes[0, x]))))
            yield Caution(
                "tied-extreme",
                f"the derivative of {name} by {variable} jumps here, as {name} has one value at t = {solution.times[tied[first]]:.4g} and "
                f"t = {solution.times[tied[other]]:.4g}: {slopes[first, x]:.4g} by the first, {slopes[other, x]:.4g} by the other one. Ask "
                "for the value at one of these times, or for a smooth maximum (time-ks).",
            )


def tied_peaks(height: np.ndarray) -> np.ndarray:
    """Numbers of the highest values (n_t,), of those that lie beside each other the first."""
    size = np.abs(height).max(initial=0.0)
    tops = np.flatnonzero(height >= height.max(initial=-np.inf) - TIED_PEAKS * size)
    low = height.max() - 10 * TIED_PEAKS * size
    apart = np.array([True, *(height[a : b + 1].min() < low for a, b in pairwise(tops))])
    return tops[apart]


SMOOTH_MAXIMUM_EXCESS = 0.05
"""Part of the largest value by which a smooth maximum may exceed it without a word, as of other errors of a response."""


def loose_maxima(solution: Solution) -> Iterator[Caution]:
    """Doubt for every smooth maximum that differs too much from the largest value, as far as all values are kept."""
    if solution.run_times is not None:
        return
    for name, response in solution.system.scene.responses.items():
        if not isinstance(response, KSStress | TimeKS) or (response.needs_motion and not solution.steps):
            continue
        considered = _values(response, solution)
        largest = float(considered.max())
        above = float(np.log(np.sum(np.exp(response.sharpness * (considered - largest))))) / response.sharpness
        if above > SMOOTH_MAXIMUM_EXCESS * abs(largest):
            sharp = np.log(considered.size) / (SMOOTH_MAXIMUM_EXCESS / 5 * abs(largest)) if largest else np.inf
            yield Caution(
                "loose-maximum",
                f"{name} is a smooth maximum of {considered.size} values, {largest + above:.4g}, and lies {above:.3g} above the largest of "
                f"them, {largest:.4g}: its parameter is too small for values of this size, and its gradient that of a mean. "
                + (
                    f"With rho = {sharp:.1g} (in 1/unit of the value) it lies at most 1 % above."
                    if largest
                    else "All of them are zero."
                ),
            )


def _values(response: KSStress | TimeKS, solution: Solution) -> np.ndarray:
    """Values (n,) that the smooth maximum is taken of."""
    if isinstance(response, KSStress):
        return np.real(response.considered(solution)).ravel()
    return np.real(response.considered(over_all_steps(response.source, solution)))


MISSED_PEAK = 0.042
"""Part of the largest magnitude by which a peak may be missed without a word: the same as of other errors by the length of steps."""


def missed_peaks(solution: Solution) -> Iterator[Caution]:
    """Doubt for every extreme over time that lies beyond the values at the steps, as far as all values are kept."""
    if solution.run_times is not None or len(solution.times) < 4:
        return
    for name, response in solution.system.scene.responses.items():
        missed = missed_part(solution.times, np.array(list(_curves(response, solution))))
        if missed > MISSED_PEAK:
            yield Caution(
                "missed-peak",
                f"{name} is the largest (or least) of the values at the steps, and between them is one that is about {missed:.1%} beyond. "
                f"Try solver.step = {np.diff(solution.times).max() / 4:.1g}.",
            )


def missed_part(times: np.ndarray, curves: np.ndarray) -> float:
    """How far a peak between the times (n,) is above the largest of some curves' values (m, n), a part of the largest magnitude."""
    size, beyond = float(np.abs(curves).max(initial=0.0)), 0.0
    for values in curves:
        before, after = _vertices(times, values)
        beyond = max(beyond, float(np.minimum(before[:-1], after[1:]).max(initial=-np.inf) - curves.max()))
    return beyond / size if size > 0 else 0.0


def changes_at_peaks(solution: Solution) -> dict[str, dict[str, float]]:
    """Extreme over time -> variable -> what its derivative differs by at the peak between the steps from that at the step next to it.

    A parabola through the three values about the largest one has its vertex at the peak, one through their derivatives tells these there.
    Of derivatives of the states alone, and where the solution holds them; a value is flat at its peak, its derivatives are not.
    """
    if changes_at_peaks not in solution.known:
        solution.known[changes_at_peaks] = _changes_at_peaks(solution)
    found: dict[str, dict[str, float]] = solution.known[changes_at_peaks]
    return found


def _changes_at_peaks(solution: Solution) -> dict[str, dict[str, float]]:
    if solution.run_times is not None or not solution.dq.shape[2]:
        return {}
    found = {}
    for name, response in solution.system.scene.responses.items():
        if isinstance(response, TimeMax | TimeMin) or (isinstance(response, MaxStress) and response.when == "all"):
            heights, slopes = _peaked(response, solution)
            step = int(first_largest(heights, RESULT_TIE_BAND))
            weights = _weights_at_vertex(solution.times[step - 1 : step + 2], heights[step - 1 : step + 2]) if step else None
            if weights is not None:
                around = np.array([slopes(step + k) for k in (-1, 0, 1)])
                changes = np.nan_to_num(weights @ around - around[1])
                found[name] = dict(zip(solution.system.design.names, map(float, changes), strict=True))
    return found


def at_peaks(gradients: dict[str, dict[str, float]], solution: Solution) -> dict[str, dict[str, float]]:
    """Derivatives of all responses, with those of extremes over time at their peaks between the steps, as by `changes_at_peaks`."""
    changes = changes_at_peaks(solution)
    return {f: {x: slope + changes[f][x] for x, slope in each.items()} if f in changes else each for f, each in gradients.items()}


def _peaked(response: TimeMax | TimeMin | MaxStress, solution: Solution) -> tuple[np.ndarray, Callable[[int], np.ndarray]]:
    """Curve (n_t,) whose largest value an extreme is, apart from its sign, and the derivatives (n_x,) of the extreme at a step."""
    if isinstance(response, MaxStress):
        components, stress = response.components(solution), np.real(response.considered(solution))
        column = int(first_largest(stress.ravel(), RESULT_TIE_BAND)) % stress.shape[1]
        return stress[:, column], lambda step: _slope(response, solution, components, (step, column))
    look, values = response.source.instants(solution), np.real(over_all_steps(response.source, solution))
    if isinstance(response, TimeMin):
        return -values, lambda step: slope_at(look(step), solution, step)
    sign = (
        np.sign(values[first_largest(response.considered(values), RESULT_TIE_BAND) % len(values)])
        if response.measure == "absolute"
        else 1.0
    )
    return sign * values, lambda step: sign * slope_at(look(step), solution, step)


def _weights_at_vertex(times: np.ndarray, values: np.ndarray) -> np.ndarray | None:
    """Weights (3,) that interpolate what is known at three times at the vertex of the parabola through three values; None without one."""
    if len(times) < 3:
        return None
    before, after = times[1] - times[0], times[2] - times[1]
    rise, fall = (values[1] - values[0]) / before, (values[1] - values[2]) / after
    if not rise + fall > 0:
        return None
    later = (rise * after - fall * before) / (2 * (rise + fall))
    left, right = later + before, later - after
    return np.array(
        [later * right / (before * (before + after)), -left * right / (before * after), later * left / (after * (before + after))]
    )


def peaks(solution: Solution) -> Iterator[tuple[int, float]]:
    """Step of the largest value of each curve that a response looks for peaks in, and by how many steps its vertex is later."""
    for response in solution.system.scene.responses.values():
        for values in _curves(response, solution):
            step = int(np.argmax(values))
            before, at, after = values[step - 1 : step + 2] if 0 < step < len(values) - 1 else (0.0, 0.0, 0.0)
            bend = before - 2 * at + after
            yield step, (before - after) / (2 * bend) if bend < 0 else 0.0


def _vertices(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the parabolas through three values in a row, (n - 2,), which are maxima in the second and in the first of both steps."""
    left, right = np.diff(times)[:-1], np.diff(times)[1:]
    rises = np.diff(values) / np.diff(times)
    bend = (rises[1:] - rises[:-1]) / (left + right)
    slope = rises[:-1] + bend * left
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.where(bend < 0, -slope / (2 * bend), np.inf)
        height = values[1:-1] + slope * place / 2
    second, first = (place >= 0) & (place <= right), (place <= 0) & (place >= -left)
    return np.where(second, height, -np.inf), np.where(first, height, -np.inf)


def _curves(response: object, solution: Solution) -> Iterator[np.ndarray]:
    """Values at all steps (n_t,) whose largest or smooth largest is the response; for an absolute one also their negatives."""
    if isinstance(response, TimeMax | TimeMin | TimeKS):
        values = np.real(over_all_steps(response.source, solution))
        absolute = isinstance(response, TimeMax | TimeKS) and response.measure == "absolute"
        yield from (values, -values) if absolute else (-values if isinstance(response, TimeMin) else values,)
    elif isinstance(response, MaxStress | KSStress) and response.when == "all":
        considered = np.real(response.considered(solution))
        yield considered[:, int(np.argmax(considered.max(axis=0)))]


MOST_PLACES = 8
"""Largest number of places of one stress that are looked at, as each asks for a derivative of its own."""
NEARLY_LARGEST, DISTANT_PLACE = 0.01, 0.1
"""Part of the stress by which a place, so far away in parts of the body's extent, may be stressed less without a remark: what a mesh or a
basis leaves open of it, so that the largest may be there."""
UNIMPORTANT_EFFECT = 1e-3
"""Part of the stress by which a variable has to change it, if it changes by all of itself, for a jump to be worth a word."""


def tied_stresses(solution: Solution) -> Iterator[Caution]:
    """Caution for every derivative of a largest stress that jumps (doubt) or nearly does (remark), where derivatives are held."""
    if solution.run_times is not None or not solution.dq.shape[2]:
        return
    for name, response in solution.system.scene.responses.items():
        if isinstance(response, MaxStress) and (solution.steps or not response.needs_motion):
            yield from _tied_stress(name, response, solution)


def _tied_stress(name: str, response: MaxStress, solution: Solution) -> Iterator[Caution]:
    components = response.components(solution)
    stress = np.real(response.signed(components))
    places = [*_tied(stress), *_nearly_tied(response, solution, stress)]
    if len(places) < 2:
        return
    slopes = np.array([_slope(response, solution, components, place) for place in places])
    words = [_where(response, solution, instant, column % components.shape[1]) for instant, column in places]
    for x, variable in enumerate(solution.system.design):
        size = abs(variable.value) or (solution.system.scene.size if variable.path.startswith("points.") else 1.0)
        if np.ptp(slopes[:, x]) > max(DERIVATIVE_JUMP * np.abs(slopes[:, x]).max(), UNIMPORTANT_EFFECT * stress.max() / size):
            k = int(np.argmax(np.abs(slopes[:, x] - slopes[0, x])))
            below = 1 - stress[places[k]] / stress.max()
            yield Caution(
                "tied-extreme",
                f"the derivative of {name} by {variable.name} jumps {'here' if below <= TIED_PEAKS else 'near here'}, as the stress of "
                f"{response.body} is {'the same' if below <= TIED_PEAKS else f'but {below:.1g} of itself larger'} {words[0]} "
                f"{'as' if below <= TIED_PEAKS else 'than'} {words[k]}: {slopes[0, x]:.4g} by the first, {slopes[k, x]:.4g} by "
                "the other one. "
                "Ask for the stress at one of these places (stress-at-point), or for a smooth maximum (ks-stress).",
                doubt=bool(below <= TIED_PEAKS),
            )


def _tied(stress: np.ndarray) -> list[tuple[int, int]]:
    """Instants and columns of the largest stress (n_t, n), each column once, in their order."""
    largest = stress.max()
    if not largest > 0:
        return []
    columns = np.flatnonzero(stress.max(axis=0) >= (1 - TIED_PEAKS) * largest)[:MOST_PLACES]
    return [(int(np.argmax(stress[:, column])), int(column)) for column in columns]


def _nearly_tied(response: MaxStress, solution: Solution, stress: np.ndarray) -> list[tuple[int, int]]:
    """Instant and column of the largest stress far from where it is largest, if it is nearly the same; of known places alone."""
    highest = stress.max(axis=0)
    try:
        place = stress_places(solution.system.scene, response.body).place
    except InputError:
        return []
    first = int(np.argmax(highest))
    places = np.resize(place, (len(highest), place.shape[1]))  # again, where the opposite sign counts too
    far = np.linalg.norm(places - places[first], axis=1) > DISTANT_PLACE * np.ptp(place, axis=0).max()
    if not far.any():
        return []
    column = int(np.argmax(np.where(far, highest, -np.inf)))
    near = (1 - NEARLY_LARGEST) * highest[first] <= highest[column] < (1 - TIED_PEAKS) * highest[first]
    return [(int(np.argmax(stress[:, column])), column)] if near else []


def _slope(response: MaxStress, solution: Solution, components: np.ndarray, place: tuple[int, int]) -> np.ndarray:
    """Total derivative (n_x,) of the stress at one place."""
    weights = np.zeros(response.signed(components).shape)
    weights[place] = 1
    found, step = response.chain(solution, components, 0.0, weights), place[0] if response.when == "all" else -1
    return slope_at(found._replace(q=None if found.q is None else found.q[step]), solution, step)


def _where(response: MaxStress, solution: Solution, instant: int, point: int) -> str:
    """Place, and time of a motion, of a stress point, in words for a message."""
    try:
        place = ", ".join(f"{x:.4g}" for x in stress_places(solution.system.scene, response.body).place[point])
        where = f"at ({place})"
    except InputError:  # of a model that does not say where its points are
        where = f"at its stress point {point}"
    return where + (f" and t = {solution.times[instant]:.4g}" if solution.steps else "")
