"""Verdicts of many designs: measured at some of them, and carried from there to those that are near.

To judge a run costs several more. Where no indicator of two designs changes by more than a part d, what a check measures changes by a
factor of (1 - d)^-POWER at most. So the verdict on one holds for the other, unless a measure lies so near its limit that this factor leads
across; and what it tells of sizes is right to this factor.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolkit.foundation.verdict import Caution, Verdict
from toolkit.sensitivity.errors.step_cautions import GRADIENTS, VALUES
from toolkit.sensitivity.frames.gradient_errors import SMALL, UNCERTAIN, FrameErrors, Slopes, doubtful_gradients
from toolkit.sensitivity.run import Run
from toolkit.studies.designs.indicators import Indicators, distances, indicators, joined, sizes_of_variables
from toolkit.validity.bodies.bent_surfaces import geometric_errors
from toolkit.validity.bodies.compressed.critical_load import Compression, compression
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.judge import codes_of_instabilities, instabilities
from toolkit.validity.motion.motion import ENERGY
from toolkit.validity.motion.noisy_forces import NOISY

POWER = 4.0
"""Power of the indicators with which a measure grows at most."""
FARTHEST = 0.15
"""Distance up to which a verdict is carried: a measure changes by a factor of two at most."""
SAME = 0.01
"""Distance up to which one verdict is enough; from farther, one is carried where those measured around it agree."""
OF_FRAMES = "geometric-gradients"
"""Code of the doubt that is found anew for every design, by errors that are carried and by its own gradients."""
BY_HALF_STEPS = "energy"
"""Code of a caution that a comparison with half the step makes a doubt or a remark: it is measured at every design."""


class Answers(NamedTuple):
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


class Carried(NamedTuple):
    """A design that a verdict is carried from, and its distance."""

    source: int
    distance: float


def answers(result: Run, judged: bool = False) -> Answers:
    """Numbers of a run that verdicts are carried by; of one that is judged itself, without cautions that its own verdict has already."""
    sizes = sizes_of_variables(result) if result.gradients else {}
    unstable = () if judged else tuple(instabilities(result.solution, result.values))
    return Answers(indicators(result), result.gradients, sizes, unstable)


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
    shares = [each / ENERGY for each in found.get("energy_balance", {}).values()]
    if noise := found.get("force_noise"):
        shares.append(noise["size"] / NOISY)
    if (steps := result.step_error) is not None:
        shares.append(_largest(steps.values.values()) / VALUES)
        shares.append(_largest(error for each in steps.gradients.values() for error in each.values()) / GRADIENTS)
    shares.append(_of_values(result) / LIMIT)
    for each in geometric_errors(result.solution).values():
        if each is not None:
            shares += [each.relative / limit for limit in (LIMIT, SMALL)]
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
    return (1 - np.minimum(distance, FARTHEST)) ** -POWER


class CarriedVerdicts:
    """Verdicts on designs: which designs are to be judged, and the verdicts on the others.

    Parameters
    ----------
    written
        What the designs are written as.
    found
        Number of a design -> what verdicts are carried by; without those that failed.
    """

    def __init__(self, written: Sequence[Indicators], found: Mapping[int, Answers]) -> None:
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
            if apart[m] <= FARTHEST:
                self._reach[[k, m]] = np.maximum(self._reach[[k, m]], apart[m])
        self.measured[k] = judged
        nearer = apart < self._nearest
        self._nearest[nearer], self._source[nearer] = apart[nearer], k
        for other in np.flatnonzero(apart <= FARTHEST):
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

    def source(self, k: int) -> Carried | None:
        """Design that the verdict on a design is carried from; None if the verdict has to be measured."""
        apart, m = float(self._nearest[k]), int(self._source[k])
        if apart > FARTHEST or growth(apart) > self._room(m, k):
            return None
        agreed = len(self._doubts[k]) == 1 and 2 * self._reach[m] >= apart
        return Carried(m, apart) if apart <= SAME or agreed else None

    def _room(self, m: int, k: int) -> float:
        """The least factor that brings a measure to its limit, among those of a measured design and what another one has of them."""
        judged, mine = self.measured[m], self.found[k]
        if judged.frame_errors is None or not judged.frame_errors.gradients:
            return judged.room
        largest = judged.frame_errors.largest(mine.gradients, mine.sizes, judged.gradient_scales)
        felt = UNCERTAIN * max(judged.of_values, largest)  # up to the limit this denies other doubts
        return min(judged.room, _room(np.array([largest, felt]) / LIMIT))

    def wanted(self) -> list[int]:
        """Designs to be measured next: the farthest ones from those that are measured first, and none that one of these may do for."""
        rest = np.array([k for k in self.found if k not in self.measured and self.source(k) is None], dtype=int)
        rest = rest[np.argsort(-self._nearest[rest], kind="stable")]
        chosen: list[int] = []
        while len(rest):
            chosen.append(int(rest[0]))
            known = self._nearest[rest] <= np.minimum(FARTHEST, 2 * self._reach[self._source[rest]])  # and yet not carried
            may_do = np.where(known, self._nearest[rest] / 2, FARTHEST)
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


def _tables(found: Mapping[int, Answers]) -> dict[tuple[object, ...], tuple[np.ndarray, ...]]:
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


def _said_there(each: Caution, carried: Carried) -> Caution:
    """A caution that begins with the name of the design that its numbers belong to."""
    return replace(each, text=f"designs[{carried.source}], which is near: {each.text}")


def _remark(carried: Carried) -> Caution:
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
        near = distances(written[first], numbers, least) <= FARTHEST
        chosen[first] = int(near.sum()) > 1
        left &= ~near
        left[first] = False  # of a number that does not exist, which is near nothing
    return chosen
