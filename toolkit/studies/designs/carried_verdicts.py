"""Verdicts of many designs: measured at some of them, and carried from there to those that are near.

To judge a run costs several more. Where no indicator of two designs changes by more than a part d, what a check measures changes by a
factor of (1 - d)^-POWER at most. So the verdict on one holds for the other, unless a measure lies so near its limit that this factor leads
across; and what it tells of sizes is right to this factor.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.sensitivity.errors.step_cautions import GRADIENTS, VALUES
from toolkit.sensitivity.frames.gradient_errors import SMALL, SMALL_OF_PARTS, FrameErrors, Slopes, doubtful_gradients
from toolkit.sensitivity.result import Result
from toolkit.studies.designs.indicators import Indicators, distances, indicators, joined, sizes_of_variables
from toolkit.validity.bodies.bent_surfaces import geometric_errors
from toolkit.validity.bodies.compressed.critical_load import compression
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.motion.motion import ENERGY
from toolkit.validity.motion.noisy_forces import NOISY

POWER = 4.0
"""Power of the indicators with which a measure grows at most."""
FARTHEST = 0.15
"""Distance up to which a verdict is carried: a measure changes by a factor of two at most."""
SAME = 0.01
"""Distance up to which one verdict is enough; a farther one is carried where those that are measured around it agree."""
OF_FRAMES = "geometric-gradients"
"""What is told anew of every design: by errors that are carried, and by its own gradients."""


class Answers(NamedTuple):
    """What the verdict on a design is carried to: its indicators, its gradients, and sizes of its variables."""

    indicators: Indicators
    gradients: Slopes
    sizes: Mapping[str, float]


class Measured(NamedTuple):
    """A verdict that was measured, and how near its measures lie to their limits.

    Attributes
    ----------
    verdict
        Of the run.
    shares
        Measures in parts of their limits, (n,).
    frame_errors
        What more floating frames change.
    """

    verdict: Verdict
    shares: np.ndarray
    frame_errors: FrameErrors | None

    @property
    def doubts(self) -> frozenset[str]:
        """Codes of what speaks against the numbers, without those that are told anew of every design."""
        return frozenset(each.code for each in self.verdict.warnings if each.doubt) - {OF_FRAMES}


class Carried(NamedTuple):
    """From which design a verdict is carried, and how far."""

    source: int
    distance: float


def answers(result: Result) -> Answers:
    """What verdicts are carried by, of a run."""
    return Answers(indicators(result), result.gradients, sizes_of_variables(result) if result.gradients else {})


def measured(result: Result) -> Measured:
    """The verdict on a run, with the shares of their limits that its main measures have."""
    verdict = result.verdict
    return Measured(verdict, _shares(result), result.frame_errors)


def _shares(result: Result) -> np.ndarray:
    """Measures in parts of their limits: of the comparisons with other runs, and of what decides whether there are such."""
    found, scene = result.measures, result.solution.system.scene
    shares = [each / ENERGY for each in found.get("energy_balance", {}).values()]
    if noise := found.get("force_noise"):
        shares.append(noise["size"] / NOISY)
    if (steps := result.step_error) is not None:
        shares += [each / VALUES for each in steps.values.values()]
        shares += [error / GRADIENTS for each in steps.gradients.values() for error in each.values()]
    for body, each in geometric_errors(result.solution).items():
        if each is not None:
            shares += [
                each.relative / limit for limit in (LIMIT, SMALL_OF_PARTS if isinstance(scene.bodies[body], CutBody) else SMALL)
            ]
    pressed = compression(result.solution, of_interest=LIMIT / 2)
    shares += [] if pressed is None else [pressed.missed / LIMIT, pressed.feigned / LIMIT, pressed.load]
    return np.array(shares, dtype=float)


def growth(distance: float | np.ndarray) -> float | np.ndarray:
    """The factor by which a measure changes at most between designs that are so far from each other."""
    return (1 - np.minimum(distance, FARTHEST)) ** -POWER


class CarriedVerdicts:
    """Which designs are to be judged, and the verdicts on the others.

    Parameters
    ----------
    written
        What the designs are written as.
    found
        Number of a design -> what verdicts are carried by; without those that failed.
    """

    def __init__(self, written: Sequence[Indicators], found: Mapping[int, Answers]) -> None:
        self.found = {k: each._replace(indicators=joined([written[k], each.indicators])) for k, each in sorted(found.items())}
        self.places: dict[tuple[object, ...], list[int]] = {}
        for k, each in self.found.items():
            self.places.setdefault(each.indicators.kind, []).append(k)
        self.tables = {
            kind: tuple(np.array([getattr(self.found[k].indicators, name) for k in keys]) for name in ("numbers", "least"))
            for kind, keys in self.places.items()
        }
        self.measured: dict[int, Measured] = {}
        self.distances: dict[int, dict[int, float]] = {}  # measured design -> those that are near it

    def learn(self, k: int, judged: Measured) -> None:
        """Keep the verdict that was measured at a design."""
        self.measured[k] = judged
        self.distances[k] = self._near(k)

    def forget(self, k: int) -> None:
        """Leave out a design that cannot be judged."""
        del self.found[k]

    def _near(self, k: int) -> dict[int, float]:
        """The designs that are not too far from one."""
        kind = self.found[k].indicators.kind
        apart = distances(self.found[k].indicators, *self.tables[kind])
        return {self.places[kind][n]: float(apart[n]) for n in np.flatnonzero(apart <= FARTHEST)}

    def source(self, k: int) -> Carried | None:
        """From where the verdict on a design is carried; None if it has to be measured."""
        around = {m: near[k] for m, near in self.distances.items() if k in near}
        if not around:
            return None
        nearest = min(around, key=lambda m: around[m])
        apart = around[nearest]
        if not self._holds(nearest, k, apart):
            return None
        alike = all(self.measured[m].doubts == self.measured[nearest].doubts for m in around)
        return Carried(nearest, apart) if apart <= SAME or (alike and self._tried(nearest, apart)) else None

    def _tried(self, m: int, apart: float) -> bool:
        """Whether another one is measured about as far from a measured design."""
        return any(other != m and 2 * each >= apart for other, each in self.distances[m].items() if other in self.measured)

    def _holds(self, m: int, k: int, apart: float) -> bool:
        """Whether no measure could be on the other side of its limit."""
        judged, factor = self.measured[m], growth(apart)
        shares = judged.shares
        if judged.frame_errors is not None and judged.frame_errors.gradients:
            own = judged.frame_errors.largest(self.found[k].gradients, self.found[k].sizes) / LIMIT
            shares = np.append(shares, own)
        return bool(np.all((shares * factor <= 1) | (shares >= factor)))

    def wanted(self) -> list[int]:
        """Designs to be measured next: none of them near to another one of these, the farthest one from those that are measured first."""
        rest = [k for k in self.found if k not in self.measured and self.source(k) is None]
        nearest = {k: min((near[k] for near in self.distances.values() if k in near), default=np.inf) for k in rest}
        rest.sort(key=lambda k: -nearest[k])
        chosen: list[int] = []
        while rest:
            chosen.append(rest[0])
            near = self._near(rest[0])
            rest = [k for k in rest if k not in near]
        return chosen

    def verdict(self, k: int) -> Verdict:
        """The verdict on a design, measured there or carried to it."""
        if k in self.measured:
            return self.measured[k].verdict
        carried = self.source(k)
        assert carried is not None
        judged, mine = self.measured[carried.source], self.found[k]
        others = [_said_there(each, carried) for each in judged.verdict.warnings if each.code != OF_FRAMES]
        about_gradients = doubtful_gradients(judged.frame_errors, mine.gradients, mine.sizes)
        measures = {**judged.verdict.measures, "carried": {"design": carried.source, "distance": carried.distance}}
        return Verdict.of([*others, *about_gradients, _remark(carried)], measures)


def _said_there(each: Caution, carried: Carried) -> Caution:
    """A caution with the name of the design that its numbers belong to."""
    return replace(each, text=f"designs[{carried.source}], which is near: {each.text}")


def _remark(carried: Carried) -> Caution:
    """Where a verdict comes from."""
    return Caution(
        "carried-verdict",
        f"what checks measure was measured at designs[{carried.source}]. No number, response, deformation, velocity or force differs "
        f"from those there by more than {carried.distance:.1%}, so that measures differ by a factor of {growth(carried.distance):.2g} at "
        'most. judged = "each" measures all designs.',
        doubt=False,
    )


def apart(written: Sequence[Indicators]) -> list[int]:
    """Numbers of designs that are too far from each other, by what they are written as, for one verdict to do for two of them."""
    if not written:
        return []
    numbers, least = (np.array([getattr(each, name) for each in written]) for name in ("numbers", "least"))
    chosen, left = [], np.ones(len(written), dtype=bool)
    while left.any():
        first = int(np.argmax(left))
        chosen.append(first)
        left &= distances(written[first], numbers, least) > FARTHEST
    return chosen
