"""Errors of a run's gradients by the number of frames: the same run with more of them, compared.

Gradients converge more slowly than values: of a wing whose displacement is off by 1 % they are by 10 %, and may have the wrong sign before.
With every part cut in half, the error is a quarter of what it was. So of numbers g, and g' with ratio r of the frames,

    error of g  =  (g' - g) r^2 / (r^2 - 1)

Parts have all shapes of their elements: what g' - g is by the shapes of a frozen basis, as far as that is known, does not fall with the
frames, and counts as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.chosen_frames import Frames
from toolkit.analyses.sensitivity.errors.basis_errors import BasisErrors, derivative
from toolkit.analyses.sensitivity.errors.step_cautions import GRADIENT_LIMIT, ROUGH_GRADIENT, VALUE_LIMIT
from toolkit.analyses.sensitivity.errors.step_error import StepError
from toolkit.analyses.sensitivity.preparation import moving, responses_of
from toolkit.components.bodies.cut_body import CutBody
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.responses.energy import Largest, magnitude_that_counts
from toolkit.scene.resolution import branches, cuttable, fewest_cut, most_frames
from toolkit.system.solution import Solution
from toolkit.validity.bodies.bent_surfaces import geometric_errors
from toolkit.validity.bodies.deformation import LIMIT, whole_bodies
from toolkit.validity.bodies.pulled_joints import EXAMINED_SHARE, lacking_joints
from toolkit.validity.bodies.stiffened_bodies import most_pulled

SMALL_GEOMETRIC_ERROR = 5e-4
"""Geometric error by the meter up to which gradients are not examined: where the parts of a wing leave 6e-4, a gradient is off by 6 %, and
so it is of a pendulum whose bending leaves 1.7e-3 in one frame, as vibrations count what changes their frequency period by period."""
UNIMPORTANT = 0.02
"""Effect of a gradient on its response, relative to that of the most important gradient, below which it is left out without a motion."""
MOST_NAMED = 6
"""Largest count of gradients that are named one by one."""
WEIGHED = ("large-deformation", "critical-load", "tension", "reference-condition")
"""Codes of doubts about effects that linear bodies lack within their frames, but have between several frames."""
BUCKLING_ROTATION = 1e-3
"""Rotation, rad, above which a body that may buckle is turned aside, so that a run with more frames shows it."""
NONE = Largest(0.0, np.zeros(0))
MANY_TIMES = 10.0
"""Part from which on an error is called many times the gradient: that is about zero then, and the ratio says nothing."""
LARGEST_FRAME_EFFECT = 0.5
"""Part of its scale by which no frames change a value of a body that keeps few shapes, as the meter knows how far it bends: those that it
leaves out vibrate then, in steps that are too long for them."""
ESTIMATE_FACTOR = 2.0
"""Factor by which the estimate of an error may be too small."""
WORTH_ADDING = 0.01
"""Error, a part of its scale, below which it is not worth a word that it adds to another one."""

Slopes = Mapping[str, Mapping[str, float]]
Reframed = Callable[[Mapping[str, Frames]], tuple[Mapping[str, float], Slopes]]
"""Values and gradients of the same analysis with other frames in some of its bodies, gradients of extremes at peaks between the steps."""


@dataclass(frozen=True)
class FrameErrors:
    """Estimated errors of a run by the number of its frames; `failure` says why there are none.

    Parts of a reduced body have more shapes together than it has, so that these are errors by its basis too.
    """

    frames: Mapping[str, tuple[int, int]]  # body -> those of the run, and those that it is compared with
    values: Mapping[str, float]
    gradients: Slopes
    failure: str = ""
    most: Mapping[str, int] = field(default_factory=dict)  # body -> elements, of which each can have a frame
    undecided: Mapping[str, float] = field(default_factory=dict)  # response -> what Newton leaves open of it, which is no change
    unknown: Collection[str] = ()  # responses that the other run does not know, which have no errors

    def largest(self, gradients: Slopes, sizes: Mapping[str, float], scales: Slopes | None = None) -> float:
        """Largest error of the gradients that count, relative to the gradient or to the largest in a motion."""
        return max(_parts(self, gradients, sizes, scales).values(), default=0.0)

    def advised(self, worst: float) -> dict[str, int]:
        """Numbers of frames that would bring an error below the limit; where signs are in doubt, twice the number."""
        factor = np.sqrt(worst / LIMIT) if worst < 1 else 4.0
        return {body: min(int(np.ceil(now * factor)), self.most[body]) for body, (now, _) in self.frames.items()}

    def record(self, gradients: Slopes, sizes: Mapping[str, float], scales: Slopes) -> dict[str, object]:
        """Errors as part of a JSON object, with the gradients whose signs are in doubt."""
        doubtful = [{"response": f, "variable": x} for f, x in _signs(self, gradients, sizes, scales)]
        return {
            "how": f"the same run with {_others(self.frames)}",
            "responses": dict(self.values),
            "gradients": {f: dict(slopes) for f, slopes in self.gradients.items()},
            "signs_in_doubt": doubtful,
            **({"failure": self.failure} if self.failure else {}),
        }


UNIMPORTANT_CHANGE = 1e-3
"""Relative change of a value by a change of the variable by its size, below which the derivative is left out."""


def frame_errors(
    solution: Solution,
    values: Mapping[str, float],
    gradients: Slopes,
    scales: Mapping[str, float],
    reframed: Reframed,
    doubted: Collection[str] = (),
    by_basis: BasisErrors | None = None,
) -> FrameErrors | None:
    """Errors of values and gradients by the number of frames; None where no body needs more frames, or can have them.

    A body that is deformed far, or that is doubted, needs more.

    Parameters
    ----------
    gradients : those of extremes over time are to be those at the peaks between the steps, as of the other run
    scales : response -> what an error of its value is compared with
    by_basis : errors by frozen bases, which are part of what more frames change
    """
    bodies = [body for body in whole_bodies(solution.system.scene) if body in {*bodies_with_more(solution), *doubted}]
    more = {body: _more(solution, body) for body in bodies if _can_have_more(solution, body)}
    if not more:
        return None
    counts = {body: (_count(solution, body), each if isinstance(each, int) else len(each) + 1) for body, each in more.items()}
    most = {body: _elements(solution, body) for body in more}
    try:
        other_values, other_slopes = reframed(more)
    except ToolkitError as error:
        return FrameErrors(counts, {}, {}, str(error), most)
    square = min(now / before for before, now in counts.values()) ** 2
    bases = by_basis.numbers if by_basis is not None and {each.name for each in by_basis.bodies} <= {*more} else {}

    def estimated(change: float, name: str) -> float:
        """Error of a number, by its name in what is known about bases."""
        known = bases.get(name)
        by_shapes = 0.0 if known is None or not change else np.clip((known.true - known.told) / change, 0.0, 1.0) * change
        return float((change - by_shapes) * square / (square - 1) + by_shapes)

    unknown = _unknown(solution, more, scales, {f: other_values[f] - value for f, value in values.items()})
    slopes = {f: row for f, row in gradients.items() if f not in unknown}
    return FrameErrors(
        counts,
        {f: estimated(other_values[f] - value, f) for f, value in values.items() if f not in unknown},
        {
            f: {x: estimated(other_slopes[f][x] - slope, derivative(f, x)) for x, slope in row.items()}
            for f, row in slopes.items()
        },
        most=most,
        undecided={
            f: max(magnitude_that_counts(each, solution, NONE), UNIMPORTANT_CHANGE * abs(values[f]))
            for f, each in responses_of(solution.system.scene, moving(solution)).items()
            if f in values
        },
        unknown=unknown,
    )


def _unknown(solution: Solution, bodies: Collection[str], scales: Mapping[str, float], changes: Mapping[str, float]) -> list[str]:
    """Responses of a motion that shapes which a reduced body leaves out change by their vibrations, and not by frames."""
    scene = solution.system.scene
    models = [scene.model(scene.bodies[body].model) for body in bodies]  # type: ignore[attr-defined]
    reduced = moving(solution) and not all(each.keeps_all or each.in_pieces for each in models)
    return [f for f, change in changes.items() if reduced and abs(change) > LARGEST_FRAME_EFFECT * scales[f]]


def bodies_with_more(solution: Solution) -> list[str]:
    """Bodies whose gradients may need more frames: deformed far, or pulling at joints whose forces are asked for."""
    pulls = any(abs(each.missing) > EXAMINED_SHARE * each.counts > 0 for each in lacking_joints(solution).values())
    pulling = {most_pulled(solution)} if pulls else set()
    return [
        body
        for body, each in geometric_errors(solution).items()
        if body in pulling or (each is not None and each.relative > SMALL_GEOMETRIC_ERROR)
    ]


def framed_doubts(cautions: Iterable[Caution]) -> set[str]:
    """Bodies with doubts that a run with more frames can weigh."""
    return {each.body for each in cautions if each.doubt and each.body and each.code in WEIGHED}


def unless_frames_deny(
    cautions: Iterable[Caution],
    solution: Solution,
    found: FrameErrors,
    scales: Mapping[str, float],
    gradients: Slopes,
    sizes: Mapping[str, float],
    slope_scales: Slopes,
) -> Iterator[Caution]:
    """The cautions, with those about what more frames know as remarks where no answer feels them.

    Values may be off by twice as much as is found. Gradients that are found within their own limit are no more doubted than those of
    bodies that no doubt is about, see `doubtful_gradients`.
    """
    values = [abs(error) / scales[f] for f, error in found.values.items() if scales[f] > 0 and abs(error) > found.undecided[f]]
    felt, steeper = max(values, default=0.0), max(_parts(found, gradients, sizes, slope_scales).values(), default=0.0)
    unfelt = not found.failure and not found.unknown and felt * ESTIMATE_FACTOR <= LIMIT and steeper <= LIMIT
    for each in cautions:
        if unfelt and each.doubt and each.code in WEIGHED and each.body in found.frames and _moves(solution, each):
            said = (
                f" The responses hardly feel it: they change by {felt:.1e} at most, and gradients by {steeper:.1e}, by the same run with "
                f"{_others(found.frames)}."
            )
            yield replace(each, text=each.text + said, doubt=False)
        else:
            yield each


def _moves(solution: Solution, doubt: Caution) -> bool:
    """Whether a run with more frames would show what is doubted.

    It does not show a loss of stability in an equilibrium, or of what is straight.
    """
    if np.isfinite(doubt.part):
        return True
    bent = geometric_errors(solution).get(doubt.body)
    return (
        moving(solution)
        and not solution.system.scene.solver.quasi_static
        and bent is not None
        and bent.rotation > BUCKLING_ROTATION
    )


def doubtful_gradients(
    found: FrameErrors | None, gradients: Slopes, sizes: Mapping[str, float], scales: Slopes
) -> Iterator[Caution]:
    """Cautions about gradients whose sign or size is in doubt.

    Parameters
    ----------
    scales : response -> variable -> the largest gradient in a motion, which errors are compared with; empty without one
    """
    if found is None:
        return
    if found.failure:
        yield Caution(
            "geometric-gradients",
            f"what the floating frames do to the gradients is not known: the same run with {_others(found.frames)} fails. {found.failure}",
            doubt=False,
        )
        return
    if found.unknown:
        yield Caution(
            "geometric-gradients",
            f"what the floating frames do to {', '.join(found.unknown)} is not known: with {_others(found.frames)} shapes that its basis "
            "leaves out vibrate, in steps that are too long for them.",
            doubt=False,
        )
    parts = _parts(found, gradients, sizes, scales)
    signs = _signs(found, gradients, sizes, scales)
    off = {pair: part for pair, part in parts.items() if part > LIMIT and pair not in signs}
    if not signs and not off:
        return
    said = [f"the sign of the gradient of {_listed(signs)} is in doubt"] if signs else []
    in_motion = ", in parts of the largest in the motion" if scales else ""
    if off:
        worst = max(off, key=lambda pair: off[pair])
        said.append(
            f"{'other ' if signs else ''}gradients are off by up to {_percent(off[worst])} ({' by '.join(worst)}{in_motion})"
        )
    yield Caution(
        "geometric-gradients",
        f"{'; '.join(said)}: found by repeating the run with {_others(found.frames)}. Gradients of bodies that "
        f"deform far need more frames than their values: write {_written(found.advised(max(parts.values())))} in the scene.",
    )


def doubtful_values(found: FrameErrors, scales: Mapping[str, float]) -> Iterator[Caution]:
    """Doubts about values that the run with other frames, which was made for the gradients, finds elsewhere.

    Parameters
    ----------
    scales : response -> what an error of its value is compared with
    """
    parts = {f: abs(error) / scales[f] for f, error in found.values.items() if scales[f] > 0 and abs(error) > found.undecided[f]}
    off = sorted((f for f, part in parts.items() if part > LIMIT), key=lambda f: -parts[f])
    if off:
        told = ", ".join(f"{f} by about {parts[f]:.1%}" for f in off[:MOST_NAMED])
        more = f" and {len(off) - MOST_NAMED} more" if len(off) > MOST_NAMED else ""
        yield Caution(
            "large-deformation",
            f"values are off where elements turn with the body: {told}{more}, relative to the peak. Found by "
            f"repeating the run with {_others(found.frames)}. Fix: write {_written(found.advised(max(parts.values())))} in the scene.",
        )


class AddedErrors(NamedTuple):
    """Estimated errors of one number by the length of the steps and by the floating frames, signed parts of its scale."""

    by_steps: float
    by_frames: float

    @property
    def part(self) -> float:
        """Magnitude of their sum: errors of different signs make up for each other."""
        return abs(self.by_steps + self.by_frames)

    def adds(self, limit_of_steps: float) -> bool:
        """Whether neither error is beyond its own limit, nor so small that the other one is nearly all."""
        sizes = abs(self.by_steps), abs(self.by_frames)
        return sizes[0] <= limit_of_steps and sizes[1] <= LIMIT and min(sizes) >= WORTH_ADDING

    def told(self, name: str) -> str:
        """Words on the sum."""
        both = f"{abs(self.by_steps):.1%} by the length of the steps, {abs(self.by_frames):.1%} by the floating frames"
        return f"{name} by about {self.part:.1%} ({both})"


def added_errors(
    found: FrameErrors | None,
    steps: StepError | None,
    scales: Mapping[str, float],
    gradients: Slopes,
    sizes: Mapping[str, float],
    slope_scales: Slopes,
) -> tuple[dict[str, AddedErrors], dict[str, AddedErrors]]:
    """Errors by steps and by frames of values and of gradients of a motion, where both count and neither is doubted by itself."""
    if found is None or steps is None:
        return {}, {}
    felt = {f: error for f, error in found.values.items() if scales[f] > 0 and abs(error) > found.undecided[f]}
    values = {f: AddedErrors(steps.changes[f] / scales[f], error / scales[f]) for f, error in felt.items()}
    slopes = {}
    for f, x in _parts(found, gradients, sizes, slope_scales):
        scale = max(abs(gradients[f][x]), slope_scales[f][x])
        if scale > 0:
            changes = steps.slope_changes[f][x], found.gradients[f][x]
            slopes[f"the derivative of {f} by {x}"] = AddedErrors(*(each / scale for each in changes))
    return {f: each for f, each in values.items() if each.adds(VALUE_LIMIT)}, {
        f: each for f, each in slopes.items() if each.adds(GRADIENT_LIMIT)
    }


def cautions_of_added(values: Mapping[str, AddedErrors], slopes: Mapping[str, AddedErrors]) -> Iterator[Caution]:
    """A doubt about numbers whose errors are small one by one and not together, or a remark on gradients that are rough by them."""
    wrong = {name: each for name, each in values.items() if each.part > LIMIT}
    wrong |= {name: each for name, each in slopes.items() if each.part > GRADIENT_LIMIT}
    rough, doubt = {name: each for name, each in slopes.items() if each.part > ROUGH_GRADIENT}, bool(wrong)
    if off := wrong or rough:
        worst = sorted(off, key=lambda name: -off[name].part)
        more = f" and {len(worst) - MOST_NAMED} more" if len(worst) > MOST_NAMED else ""
        yield Caution(
            "added-errors" if doubt else "rough-gradients",
            "errors of several causes, each within its limit, add up: "
            f"{'; '.join(off[name].told(name) for name in worst[:MOST_NAMED])}{more}, "
            f"in parts of the largest in the motion (limit {LIMIT:.0%} of values, {GRADIENT_LIMIT:.0%} of derivatives). Fix: a shorter "
            "solver.step, or more frames.",
            doubt,
        )


def _parts(
    found: FrameErrors, gradients: Slopes, sizes: Mapping[str, float], scales: Slopes | None = None
) -> dict[tuple[str, str], float]:
    """Response and variable -> relative error of each gradient that counts.

    The error is relative to the gradient, or to the largest in a motion.
    """
    parts: dict[tuple[str, str], float] = {}
    for f, errors in found.gradients.items():
        most = max((abs(slope) * sizes[x] for x, slope in gradients[f].items()), default=0.0)
        least = 0.0 if scales else UNIMPORTANT * most  # in a motion the scale of a small one is a small effect of its variable
        for x, error in errors.items():
            if error and max(abs(error), abs(gradients[f][x])) * sizes[x] > max(least, found.undecided[f]):
                scale = max(abs(gradients[f][x]), scales[f][x] if scales else 0.0)
                parts[f, x] = abs(error) / scale if scale else np.inf
    return parts


def _signs(found: FrameErrors, gradients: Slopes, sizes: Mapping[str, float], scales: Slopes) -> list[tuple[str, str]]:
    """Response and variable of gradients whose sign is in doubt.

    The error, or twice the error, leads them to the other side of zero.
    """
    return [
        (f, x)
        for (f, x), part in _parts(found, gradients, sizes, scales).items()
        if part > LIMIT and gradients[f][x] * (gradients[f][x] + ESTIMATE_FACTOR * found.gradients[f][x]) <= 0
    ]


def _written(frames: Mapping[str, int]) -> str:
    return ", ".join(f"bodies.{body}.frames = {number}" for body, number in frames.items())


def _percent(part: float) -> str:
    """Part of a gradient in percent; many times where the gradient itself is about zero."""
    return f"{part:.0%}" if part < MANY_TIMES else "many times their size"


def _others(frames: Mapping[str, tuple[int, int]]) -> str:
    return ", ".join(f"{more} frames instead of {now} in {body}" for body, (now, more) in frames.items())


def _listed(pairs: list[tuple[str, str]]) -> str:
    names = [" by ".join(pair) for pair in pairs]
    return ", ".join(names[:MOST_NAMED]) + (f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else "")


def _can_have_more(solution: Solution, body: str) -> bool:
    return body in cuttable(solution.system.scene) and _count(solution, body) < _elements(solution, body)


def _elements(solution: Solution, body: str) -> int:
    """Number of elements, each of which can have a frame of its own, of a body that can be cut."""
    return most_frames(solution.system.scene, body)


def _count(solution: Solution, body: str) -> int:
    written = solution.system.scene.bodies[body]
    return len(written.cuts) - 1 if isinstance(written, CutBody) else 1


def _more(solution: Solution, body: str) -> Frames:
    """Nodes where the body is cut if each of its parts is halved, as far as it has more than one element.

    Where elements branch, nodes have no numbers along them: there it is twice as many frames.
    """
    scene = solution.system.scene
    written = scene.bodies[body]
    if branches(scene, body):
        return min(max(2 * _count(solution, body), fewest_cut(scene, body)), _elements(solution, body))
    cuts = written.cuts if isinstance(written, CutBody) else (0, _elements(solution, body))
    inner = {*cuts[1:-1], *((one + other) // 2 for one, other in pairwise(cuts) if other - one > 1)}
    return tuple(sorted(inner))
