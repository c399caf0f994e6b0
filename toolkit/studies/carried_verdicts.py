"""Verdicts of many designs: measured at some of them, and carried from there to those that are near.

Indicators of how far two designs are apart: their numbers, their answers, and the sizes of their states and joint forces.

All of it is at hand after a run, while to judge a run costs several more. What a check measures is a smooth function of these numbers, of
a power that is seldom above the fourth: the growth of an element that turns goes with the second power of a deflection.

To judge a run costs several more. Where no indicator of two designs changes by more than a part d, what a check measures changes by a
factor of (1 - d)^-INDICATOR_POWER at most. So the verdict on one holds for the other, unless a measure lies so near its limit that
this factor leads across; and what it tells of sizes is right to this factor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.errors.step_cautions import GRADIENT_LIMIT, VALUE_LIMIT
from toolkit.analyses.sensitivity.errors.step_error import DERIVATIVE_FACTOR
from toolkit.analyses.sensitivity.gradient_errors import (
    ESTIMATE_FACTOR,
    SMALL_GEOMETRIC_ERROR,
    FrameErrors,
    Slopes,
    doubtful_gradients,
)
from toolkit.analyses.sensitivity.preparation import response_scales, typical_size, variable_sizes
from toolkit.analyses.sensitivity.run import UNIMPORTANT_EFFECT, Run
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.extremes import peaks
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution, deforming, elastic_coordinates
from toolkit.validity.bodies.bent_surfaces import geometric_errors
from toolkit.validity.bodies.critical_load import Compression, compression
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.judge import codes_of_instabilities, instabilities
from toolkit.validity.motion import ENERGY_DEFECT_LIMIT, FORCE_NOISE_LIMIT

POSITION_SCALE = 0.1
"""Part of the model size that changes of positions are compared with, where these are nearer to the origin."""
VERTEX_ERROR = 0.05
"""Error of the vertices of parabolas, as a part of a step."""
DISTANCE_DIGITS = 9
"""Decimal digits that distances are rounded to, so that round-off does not decide which of two equal ones is larger."""
ZERO_VELOCITY = 1e-6
"""Part of the largest velocity, or joint force, of a scene below which another one is taken for zero."""


class Indicators(NamedTuple):
    """Numbers of one design and of its run, by which designs are compared.

    Attributes
    ----------
    numbers
        What changes from one design to the next, (n,).
    least
        What a change is compared with where the number itself is smaller than this, (n,).
    kind
        What has to be the same in designs that are near each other: the number of steps, whether all of them went well, and at which ones
        there are peaks.
    """

    numbers: np.ndarray
    least: np.ndarray
    kind: tuple[object, ...] = ()


def distances(one: Indicators, numbers: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Distances of a design from others, (n_d,): the largest change of a number, as a part of the larger one of both.

    Parameters
    ----------
    one
        The design.
    numbers, least
        As of `Indicators`, of n_d others, (n_d, n).
    """
    scale = np.maximum(np.maximum(abs(numbers), abs(one.numbers)), np.maximum(least, one.least))
    change = abs(numbers - one.numbers)
    parts = np.divide(change, scale, out=np.zeros_like(change), where=change != 0)
    found = np.nan_to_num(parts, nan=np.inf).max(axis=1, initial=0.0)  # what does not exist is near nothing
    return np.round(found, DISTANCE_DIGITS)


def written_numbers(scene: Scene, designs: Sequence[Mapping[str, float]]) -> list[Indicators]:
    """Numbers that designs are written as: all that any of them gives; where one gives none, the scene's own."""
    names = [name for name in dict.fromkeys(name for each in designs for name in each) if _is_known(scene, name)]
    own = {name: scene.value_of(name) for name in names}
    size = loaded(scene).size
    least = np.array([POSITION_SCALE * size if scene.paths_of(name)[0].startswith("points.") else 0.0 for name in names])
    return [Indicators(np.array([_real(each.get(name, own[name])) for name in names]), least) for each in designs]


def _is_known(scene: Scene, name: Any) -> bool:
    """Whether a name leads to a finite number of the scene; a design that gives another one fails."""
    try:
        return isinstance(name, str) and np.isfinite(scene.value_of(name))
    except ToolkitError:
        return False


def _real(number: Any) -> float:
    """A number of a design as a float; nan if it is none, with which the design fails."""
    try:
        return float(number)
    except (TypeError, ValueError, OverflowError):
        return np.nan


def joined(parts: Sequence[Indicators]) -> Indicators:
    """Several indicators of one design, joined to one."""
    numbers, least = (np.concatenate(each) for each in zip(*(part[:2] for part in parts), strict=True))
    return Indicators(numbers, least, tuple(word for part in parts for word in part.kind))


def indicators(result: Run) -> Indicators:
    """Indicators of a run: its answers, the sizes of its states, and what must be equal in designs near to it."""
    solution = result.solution
    found = joined([_of_answers(result), *_of_states(solution)])
    options = solution.options or solution.system.scene.solver
    went_well = solution.correction <= options.tolerance, not solution.halved
    kind = len(found.numbers), solution.steps, result.method, *went_well
    return found._replace(kind=(*kind, *_peaks(solution)) if result.gradients else kind)


def _peaks(solution: Solution) -> Iterator[float]:
    """Steps at which peaks over time are, and on which side of them by more than a quarter of a step.

    The derivative of a peak is that at its step. Of steps half as long another one is nearer from a quarter of a step on, so that what
    they tell of derivatives jumps there; a peak that lies close to that is like no other one.
    """
    if solution.run_times is None and solution.steps:
        for step, later in peaks(solution):
            yield step
            yield later if abs(abs(later) - 0.25) < VERTEX_ERROR else np.sign(later) * (abs(later) > 0.25)


def sizes_of_variables(result: Run) -> dict[str, float]:
    """Sizes of the variables as by `variable_sizes`, without looking at the answers where that is not needed."""
    scene, variables = result.solution.system.scene, list(result.solution.system.design)
    if variables and all(each.value != 0 or each.path.startswith("points.") for each in variables):
        return {each.name: typical_size(scene, each) for each in variables}
    return variable_sizes(scene, result)


def _of_answers(result: Run) -> Indicators:
    """Indicators of the responses: their values, and their gradients relative to the largest of each."""
    values = np.array(list(result.values.values()), dtype=float)
    if not result.gradients:
        return Indicators(values, np.zeros(len(values)))
    sizes = sizes_of_variables(result)
    scales = response_scales(result, sizes)
    slopes = np.array([[result.gradients[f][x] * size for x, size in sizes.items()] for f in result.values])
    most = DERIVATIVE_FACTOR * abs(slopes).max(axis=1, initial=0.0, keepdims=True)
    least = np.array([UNIMPORTANT_EFFECT * scales[f] for f in result.values])
    return Indicators(np.append(values, slopes), np.append(least, np.broadcast_to(most, slopes.shape)))


def _of_states(solution: Solution) -> list[Indicators]:
    """Indicators of the states: largest and mean deformations, velocities, accelerations, joint forces, and the step's error."""
    system = solution.system
    starts = sorted({*system.numbering.first.values(), system.n_q})
    bodies = [slice(*each) for each in pairwise(starts)]
    rows = sorted({*(row - system.n_q for row in system.numbering.row.values()), solution.multipliers.shape[1]})
    joints = [slice(*each) for each in pairwise(rows)]
    bent = [elastic_coordinates(solution, body) for body in deforming(system.scene)]
    error = np.full((1, 1), solution.local_error or 0.0)
    of_time = (solution.q, bent), (solution.v, bodies), (solution.a, bodies), (solution.multipliers, joints), (error, [slice(1)])
    return [_sizes_over_time(np.real(states) ** 2, places) for states, places in of_time]


def _sizes_over_time(squares: np.ndarray, places: Sequence[slice | np.ndarray]) -> Indicators:
    """Largest and mean norm over time of some columns of states, from the squares of these, (n_t, n)."""
    over_time = np.array([[each.max(initial=0.0), each.mean()] for each in (squares[:, where].sum(axis=1) for where in places)])
    found = np.sqrt(over_time).ravel()
    return Indicators(found, np.full(len(found), ZERO_VELOCITY * found.max(initial=0.0)))


INDICATOR_POWER = 4.0
"""Power of the indicators with which a measure grows at most."""
LARGEST_CARRYING_DISTANCE = 0.15
"""Distance up to which a verdict is carried: a measure changes by a factor of two at most."""
ONE_VERDICT_DISTANCE = 0.01
"""Distance up to which one verdict is enough; from farther, one is carried where those measured around it agree."""
OF_FRAMES = "geometric-gradients"
"""Code of the doubt that is found anew for every design, by errors that are carried and by its own gradients."""
BY_HALF_STEPS = "energy"
"""Code of a caution that a comparison with half the step makes a doubt or a remark: it is measured at every design."""


class DesignAnswers(NamedTuple):
    """Indicators, gradients and sizes of variables of a design, by which a verdict is carried, and cautions about its own stability."""

    indicators: Indicators
    gradients: Slopes
    sizes: Mapping[str, float]
    unstable: tuple[Caution, ...] = ()


class Measured(NamedTuple):
    """A verdict that was measured, and how near its measures lie to their limits.

    Attributes
    ----------
    verdict
        Of the run.
    room
        The least factor that brings any measure to its limit, or back to it.
    frame_errors
        What more floating frames change.
    gradient_scales
        Response -> variable -> the largest gradient in a motion, which these errors are compared with; empty without one.
    of_values
        The largest error of a value by frames, as a part of its scale.
    """

    verdict: Verdict
    room: float
    frame_errors: FrameErrors | None
    gradient_scales: Slopes
    of_values: float = 0.0

    @property
    def doubts(self) -> frozenset[str]:
        """Codes of the doubts, without those that are found anew for every design."""
        return frozenset(each.code for each in self.verdict.warnings if each.doubt) - _own_codes()


class CarriedVerdict(NamedTuple):
    """A design that a verdict is carried from, and its distance."""

    source: int
    distance: float


def answers(result: Run, judged: bool = False) -> DesignAnswers:
    """Numbers of a run that verdicts are carried by; of one that is judged itself, without cautions that its own verdict has already."""
    sizes = sizes_of_variables(result) if result.gradients else {}
    unstable = () if judged else tuple(instabilities(result.solution, result.values))
    return DesignAnswers(indicators(result), result.gradients, sizes, unstable)


def measured(result: Run, alone: bool = False) -> Measured:
    """The verdict on a run, with the shares of their limits that its main measures have.

    These are left out if no other design is near.
    """
    verdict, errors = result.verdict, result.weighed_frames
    if alone or any(each.code == BY_HALF_STEPS for each in verdict.warnings):
        return Measured(verdict, 0.0, errors, {} if errors is None else result.gradient_scales)
    return Measured(verdict, _room(_shares(result)), errors, {} if errors is None else result.gradient_scales, _of_values(result))


def _shares(result: Run) -> np.ndarray:
    """Measures relative to their limits, both of comparisons with other runs and of what decides whether these are made."""
    found = result.measures
    shares = [each / ENERGY_DEFECT_LIMIT for each in found.get("energy_balance", {}).values()]
    if noise := found.get("force_noise"):
        shares.append(noise["size"] / FORCE_NOISE_LIMIT)
    if (steps := result.step_error) is not None:
        shares.append(_largest(steps.values.values()) / VALUE_LIMIT)
        shares.append(_largest(error for each in steps.gradients.values() for error in each.values()) / GRADIENT_LIMIT)
    shares.append(_of_values(result) / LIMIT)
    limits = zip(result.added_errors, (LIMIT, GRADIENT_LIMIT), strict=True)
    shares += [_largest(each.part for each in added.values()) / limit for added, limit in limits]
    for each in geometric_errors(result.solution).values():
        if each is not None:
            shares += [each.relative / limit for limit in (LIMIT, SMALL_GEOMETRIC_ERROR)]
    pressed = result.solution.known.get(Compression) or compression(result.solution, of_interest=LIMIT / 2)
    shares += [] if pressed is None else [pressed.missed / LIMIT, pressed.feigned / LIMIT, pressed.load]
    return np.array(shares, dtype=float)


def _largest(errors: Iterable[float]) -> float:
    """The largest error, since one is enough for a doubt; undefined if any is."""
    return float(np.max([0.0, *errors]))


def _of_values(result: Run) -> float:
    """The largest error of a value by frames, as a part of its scale."""
    errors, scales = result.weighed_frames, result.scales
    return 0.0 if errors is None else _largest(abs(error) / scales[f] for f, error in errors.values.items() if scales[f] > 0)


def growth(distance: float | np.ndarray) -> float | np.ndarray:
    """Largest factor by which a measure changes between designs that are so far from each other."""
    return (1 - np.minimum(distance, LARGEST_CARRYING_DISTANCE)) ** -INDICATOR_POWER


class CarriedVerdicts:
    """Verdicts on designs: which designs are to be judged, and the verdicts on the others.

    Parameters
    ----------
    written
        What the designs are written as.
    found
        Number of a design -> what verdicts are carried by; without those that failed.
    """

    def __init__(self, written: Sequence[Indicators], found: Mapping[int, DesignAnswers]) -> None:
        self.found = {k: each._replace(indicators=joined([written[k], each.indicators])) for k, each in sorted(found.items())}
        self.measured: dict[int, Measured] = {}
        self._alike = _tables(self.found)
        size = max(self.found, default=-1) + 1
        self._nearest, self._source = np.full(size, np.inf), np.full(size, -1)
        self._doubts: list[set[frozenset[str]]] = [set() for _ in range(size)]  # of all that are measured around a design
        self._reach = np.zeros(size)  # how far from a measured design another one is measured, of those that are not too far

    def learn(self, k: int, judged: Measured) -> None:
        """Keep the verdict that was measured at a design."""
        apart = self._apart(k)
        for m in self.measured:
            if apart[m] <= LARGEST_CARRYING_DISTANCE:
                self._reach[[k, m]] = np.maximum(self._reach[[k, m]], apart[m])
        self.measured[k] = judged
        nearer = apart < self._nearest
        self._nearest[nearer], self._source[nearer] = apart[nearer], k
        for other in np.flatnonzero(apart <= LARGEST_CARRYING_DISTANCE):
            self._doubts[other].add(judged.doubts)

    def forget(self, k: int) -> None:
        """Leave out a design that cannot be judged."""
        del self.found[k]

    def _apart(self, k: int) -> np.ndarray:
        """Distances of all designs from one; those of another kind are far."""
        keys, numbers, least = self._alike[self.found[k].indicators.kind]
        apart = np.full(len(self._nearest), np.inf)
        apart[keys] = distances(self.found[k].indicators, numbers, least)
        return apart

    def source(self, k: int) -> CarriedVerdict | None:
        """Design that the verdict on a design is carried from; None if the verdict has to be measured."""
        apart, m = float(self._nearest[k]), int(self._source[k])
        if apart > LARGEST_CARRYING_DISTANCE or growth(apart) > self._room(m, k):
            return None
        agreed = len(self._doubts[k]) == 1 and 2 * self._reach[m] >= apart
        return CarriedVerdict(m, apart) if apart <= ONE_VERDICT_DISTANCE or agreed else None

    def _room(self, m: int, k: int) -> float:
        """The least factor that brings a measure to its limit, among those of a measured design and what another one has of them."""
        judged, mine = self.measured[m], self.found[k]
        if judged.frame_errors is None or not judged.frame_errors.gradients:
            return judged.room
        largest = judged.frame_errors.largest(mine.gradients, mine.sizes, judged.gradient_scales)
        felt = ESTIMATE_FACTOR * max(judged.of_values, largest)  # up to the limit this denies other doubts
        return min(judged.room, _room(np.array([largest, felt]) / LIMIT))

    def wanted(self) -> list[int]:
        """Designs to be measured next: the farthest ones from those that are measured first, and none that one of these may do for."""
        rest = np.array([k for k in self.found if k not in self.measured and self.source(k) is None], dtype=int)
        rest = rest[np.argsort(-self._nearest[rest], kind="stable")]
        chosen: list[int] = []
        while len(rest):
            chosen.append(int(rest[0]))
            known = self._nearest[rest] <= np.minimum(
                LARGEST_CARRYING_DISTANCE, 2 * self._reach[self._source[rest]]
            )  # and yet not carried
            may_do = np.where(known, self._nearest[rest] / 2, LARGEST_CARRYING_DISTANCE)
            rest = rest[1:][(self._apart(chosen[-1])[rest] > may_do)[1:]]
        return chosen

    def verdict(self, k: int) -> Verdict:
        """The verdict on a design, measured there or carried to it."""
        if k in self.measured:
            return self.measured[k].verdict
        carried = self.source(k)
        assert carried is not None
        judged, mine = self.measured[carried.source], self.found[k]
        own = _own_codes()
        others = [_said_there(each, carried) for each in judged.verdict.warnings if each.code not in own]
        about_gradients = doubtful_gradients(judged.frame_errors, mine.gradients, mine.sizes, judged.gradient_scales)
        measures = {**judged.verdict.measures, "carried": {"design": carried.source, "distance": carried.distance}}
        return Verdict.of([*others, *mine.unstable, *about_gradients, _remark(carried)], measures)


def _tables(found: Mapping[int, DesignAnswers]) -> dict[tuple[object, ...], tuple[np.ndarray, ...]]:
    """Kind of designs -> their numbers among all, and their indicators as tables."""
    alike: dict[tuple[object, ...], list[int]] = {}
    for k, each in found.items():
        alike.setdefault(each.indicators.kind, []).append(k)
    return {
        kind: (np.array(keys), *(np.array([found[k].indicators[n] for k in keys]) for n in (0, 1)))
        for kind, keys in alike.items()
    }


def _room(shares: np.ndarray) -> float:
    """The least factor that brings a measure to its limit, or back to it; none where a measure does not exist."""
    with np.errstate(divide="ignore"):
        found = np.maximum(abs(shares), 1 / abs(shares)).min(initial=np.inf)
    return float(np.nan_to_num(found, nan=0.0, posinf=np.inf))


def _own_codes() -> frozenset[str]:
    """Codes of cautions that are found anew for every design."""
    return codes_of_instabilities() | {OF_FRAMES}


def _said_there(each: Caution, carried: CarriedVerdict) -> Caution:
    """A caution that begins with the name of the design that its numbers belong to."""
    return replace(each, text=f"designs[{carried.source}], which is near: {each.text}")


def _remark(carried: CarriedVerdict) -> Caution:
    """A remark that says where a verdict is carried from."""
    return Caution(
        "carried-verdict",
        f"what checks measure was measured at designs[{carried.source}]. No number, response, deformation, velocity or force differs "
        f"from those there by more than {carried.distance:.1%}, so that measures differ by a factor of {growth(carried.distance):.3g} at "
        'most. judged = "each" measures all designs.',
        doubt=False,
    )


def apart(written: Sequence[Indicators]) -> dict[int, bool]:
    """Numbers of designs that are too far from each other to share a verdict -> whether any other design is near.

    The distances are between what the designs are written as.
    """
    if not written:
        return {}
    numbers, least = (np.array([getattr(each, name) for each in written]) for name in ("numbers", "least"))
    chosen, left = {}, np.ones(len(written), dtype=bool)
    while left.any():
        first = int(np.argmax(left))
        near = distances(written[first], numbers, least) <= LARGEST_CARRYING_DISTANCE
        chosen[first] = int(near.sum()) > 1
        left &= ~near
        left[first] = False  # of a number that does not exist, which is near nothing
    return chosen
