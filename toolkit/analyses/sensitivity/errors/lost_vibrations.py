"""Vibrations that a load or the start excites and that the steps take out before they have lasted: what they would do to the responses.

Steps longer than about a third of a period keep the mean of a vibration and annihilate the rest within few steps, with every other long
step alike, so that runs with other steps agree about what they all have lost. The linearised motion tells it instead (`lost_motion`): added
to the states of the run, it gives the responses as they would be.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from toolkit.analyses.sensitivity.errors.excited_vibrations import error_after, kicks
from toolkit.analyses.sensitivity.errors.lost_motion import Lost, derivatives_of_modes, lost_motion, sizes_in_motion
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.near_ties import spread
from toolkit.foundation.processes import one_thread
from toolkit.responses.extremes import TimeKS, TimeMax, TimeMin
from toolkit.responses.response import Response
from toolkit.responses.stress import StressResponse
from toolkit.responses.windows import steps_seen
from toolkit.solvers.transient.scheme import generalized_alpha
from toolkit.system.solution import Solution

FIRST_STATES, MOST_STATES = 40, 120
"""Number of states at which responses with lost vibrations are evaluated: to see whether these count, and by how much."""
LASTING_DECAYS = 3.0
"""Decays, of the logarithm of the amplitude, that a vibration lasts."""
UNIMPORTANT_MOTION = 1e-3
"""Part of the motion of a body, or of its deformation, of velocities and of joint forces below which a vibration changes no response."""
WANTED_ERROR = 0.05
"""Largest relative error of lost vibrations in a run that is to keep them: 0.05 rad of their phase."""
MOST_MODES = 6
"""Largest number of modes that are examined one by one."""
IMPORTANT_CHANGE = 0.02
"""Change of a response by lost vibrations that counts, relative to its largest magnitude."""


class LostVibration(NamedTuple):
    """One vibration that steps take out.

    Attributes
    ----------
    rate
        Angular frequency, in 1/time.
    share
        What it adds to the response that it changes most, a part of the largest magnitude.
    lasts
        Time from its beginning to the end, or until it is damped away.
    """

    rate: float
    share: float
    lasts: float


class LostVibrations(NamedTuple):
    """Vibrations that the steps have taken out, and what they would add to the responses.

    Attributes
    ----------
    values
        Response -> its value with them.
    errors
        Response -> the change of its value, a part of the largest magnitude.
    swings
        Response -> the same whatever their phase is.
    vibrations
        Those that count, the slowest first.
    gradients
        Finds response -> variable -> what they add to the derivative; None where derivatives of the states are not known.
    """

    values: dict[str, float]
    errors: dict[str, float]
    swings: dict[str, float]
    vibrations: list[LostVibration]
    gradients: Callable[[], dict[str, dict[str, float]] | None]

    def told(self, unit: str) -> str:
        """A phrase that names the lost vibrations, with frequencies in a unit."""
        frequencies = list(dict.fromkeys(f"{each.rate / (2 * np.pi):.4g}" for each in self.vibrations))
        if len(frequencies) == 1:
            return f"a vibration of {frequencies[0]} {unit}"
        return f"vibrations of {frequencies[0]} to {frequencies[-1]} {unit}"


def lost_vibrations(solution: Solution, responses: Mapping[str, Response], scales: Mapping[str, float]) -> LostVibrations | None:
    """Vibrations that a motion has lost; None if none of them counts in any response, or if they are not known.

    Parameters
    ----------
    responses, scales : dict
        Name -> response, and its largest magnitude in the motion.
    """
    options = solution.options or solution.system.scene.solver
    if options.quasi_static or solution.run_times is not None or not solution.system.compiled or solution.steps < 2:
        return None
    try:
        return _lost_by_kicks(solution, {f: each for f, each in responses.items() if scales.get(f, 0.0) > 0}, scales)
    except (ToolkitError, np.linalg.LinAlgError):
        return None


@one_thread()
def _lost_by_kicks(solution: Solution, looked: Mapping[str, Response], scales: Mapping[str, float]) -> LostVibrations | None:
    """Vibrations that a motion with inertia has lost after its kicks; None if none of them counts."""
    if not (found := kicks(solution)):
        return None
    seen = _at(solution, _looked_at(solution, looked, MOST_STATES))
    lost = [each for kick in found if (each := lost_motion(solution, kick, seen.times)) is not None]
    sizes = [sizes_in_motion(seen, each) for each in lost]
    if not max((float(each.max(initial=0.0)) for each in sizes), default=0.0) > UNIMPORTANT_MOTION:
        return None
    few = _looked_at(seen, looked, FIRST_STATES)
    first = VibrationComparison(_at(seen, few), [each.at(few) for each in lost], looked, scales)
    return _found(solution, VibrationComparison(seen, lost, looked, scales), sizes) if first.counts else None


def _looked_at(solution: Solution, responses: Mapping[str, Response], count: int) -> np.ndarray:
    """Numbers of some states of a motion, among them the first ones and those that responses name."""
    last = len(solution.times) - 1
    if last <= count:
        return np.arange(last + 1)
    named = [step for each in responses.values() for step in steps_seen(each, solution.times)]
    return np.unique([*range(count // 4), *spread(last, count), *named])


def _at(solution: Solution, steps: np.ndarray) -> Solution:
    """The motion at some of its times."""
    if len(steps) == len(solution.times):
        return solution
    names = ("times", "q", "v", "a", "multipliers", "dq", "dv", "da", "dmultipliers")
    return replace(solution, **{name: getattr(solution, name)[steps] for name in names})


class VibrationComparison:
    """Responses of a motion with and without the vibrations that it has lost.

    Parameters
    ----------
    seen : Solution
        The motion at some of its times.
    lost : list
        What it has lost, at the same times.
    responses, scales : dict
        As of `lost_vibrations`.
    """

    def __init__(self, seen: Solution, lost: list[Lost], responses: Mapping[str, Response], scales: Mapping[str, float]) -> None:
        self.seen, self.lost, self.responses, self.scales = seen, lost, responses, scales
        self.everything = [np.ones(len(each.modes.rates)) for each in lost]
        self.own = self.values(seen)

    def values(self, solution: Solution) -> dict[str, float]:
        """Values of the responses for a motion, by name."""
        return {name: float(np.real(each.value(solution))) for name, each in self.responses.items()}

    def errors(self, values: Mapping[str, float]) -> dict[str, float]:
        """Changes of the responses, parts of their largest magnitudes."""
        return {f: abs(value - self.own[f]) / self.scales[f] for f, value in values.items()}

    def vibrating(self, turned: float, only: list[np.ndarray]) -> Solution:
        """The motion with the lost vibrations of some modes added, later by a phase."""
        q, v, a, multipliers = self.seen.q, self.seen.v, self.seen.a, self.seen.multipliers
        for each, wanted in zip(self.lost, only, strict=True):
            more = each.states(turned, wanted)
            q, v, a, multipliers = q + more[0], v + more[1], a + more[2], multipliers + more[3]
        return replace(self.seen, q=q, v=v, a=a, multipliers=multipliers)

    @cached_property
    def with_all(self) -> dict[str, float]:
        """Values of the responses with all lost vibrations added."""
        return self.values(self.vibrating(0.0, self.everything))

    @cached_property
    def swings(self) -> dict[str, float]:
        """Changes of the responses by all lost vibrations, whatever their phase is."""
        return self._swings(self.errors(self.with_all), self.everything)

    def swing(self, kick: int, mode: int) -> float:
        """Largest change of any response that one mode makes, whatever its phase is."""
        only = [np.zeros_like(each) for each in self.everything]
        only[kick][mode] = 1.0
        return max(self._swings(self.errors(self.values(self.vibrating(0.0, only))), only).values())

    def _swings(self, errors: Mapping[str, float], only: list[np.ndarray]) -> dict[str, float]:
        turned = self.errors(self.values(self.vibrating(np.pi / 2, only)))
        return {f: float(np.hypot(errors[f], turned[f])) for f in errors}

    @property
    def counts(self) -> bool:
        """Whether the lost vibrations change any response by more than `IMPORTANT_CHANGE`."""
        return max(self.swings.values(), default=0.0) > IMPORTANT_CHANGE


def _found(solution: Solution, compared: VibrationComparison, sizes: list[np.ndarray]) -> LostVibrations | None:
    """Lost vibrations that count; None if none does."""
    if not compared.counts:
        return None
    largest = sorted(((size, k, i) for k, each in enumerate(sizes) for i, size in enumerate(each)), reverse=True)[:MOST_MODES]
    vibrations = []
    for _, k, i in largest:
        each, share = compared.lost[k], compared.swing(k, i)
        if share > IMPORTANT_CHANGE / 4:
            fading = float(each.modes.damping[i] * each.modes.rates[i])
            lasts = min(float(each.passed[-1]), LASTING_DECAYS / fading if fading > 0 else np.inf)
            vibrations.append(LostVibration(float(each.modes.rates[i]), share, lasts))
    errors = compared.errors(compared.with_all)
    return (
        LostVibrations(compared.with_all, errors, compared.swings, sorted(vibrations), partial(_gradients, solution, compared))
        if vibrations
        else None
    )


def _gradients(solution: Solution, compared: VibrationComparison) -> dict[str, dict[str, float]] | None:
    """Changes of derivatives by lost vibrations, response -> variable; None where the run has no derivatives of its states."""
    if not solution.system.n_x or solution.dq.shape[-1] != solution.system.n_x:
        return None
    states = compared.vibrating(0.0, compared.everything)
    vibrating = [_with_derivatives(states, solution, compared, at_peaks) for at_peaks in (False, True)]
    names, found = solution.system.design.names, {}
    for f, each in compared.responses.items():
        slopes = each.evaluate(vibrating[_is_extreme(each)])[1] - each.evaluate(compared.seen)[1]
        found[f] = dict(zip(names, map(float, slopes), strict=True))
    return found


def _is_extreme(response: Response) -> bool:
    """Whether a response looks for a peak over time."""
    return isinstance(response, TimeMax | TimeMin | TimeKS) or (isinstance(response, StressResponse) and response.when == "all")


def _with_derivatives(states: Solution, solution: Solution, compared: VibrationComparison, at_peaks: bool) -> Solution:
    """States with the derivatives that were seen, to which those of the lost vibrations are added."""
    seen = compared.seen
    found = [seen.dq, seen.dv, seen.da, seen.dmultipliers]
    for each in compared.lost:
        by_mode = derivatives_of_modes(solution, each, at_peaks)
        bases = (*[each.modes.shapes] * 3, each.modes.forces)
        changes = zip(found, bases, (*by_mode, by_mode[0]), strict=True)
        found = [known + np.einsum("qm,tmx->tqx", basis, change) for known, basis, change in changes]
    dq, dv, da, dmultipliers = found
    return replace(states, dq=dq, dv=dv, da=da, dmultipliers=dmultipliers)


def steps_that_keep(lost: LostVibrations, options: RunOptions, least: int, most: int) -> int | None:
    """Number of steps, `least` or more, that keep most of the lost vibrations with their phase; None beyond `most`."""
    scheme, total = generalized_alpha(options.scheme, options.rho_inf), sum(each.share for each in lost.vibrations)
    steps = least
    while steps <= most:
        step = options.end_time / steps
        wrong = sum(each.share * error_after(scheme, each.rate, step, each.lasts) for each in lost.vibrations)
        if wrong <= WANTED_ERROR * total:
            return steps
        steps = -(-5 * steps // 4)
    return None
