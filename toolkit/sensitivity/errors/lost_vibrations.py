"""Vibrations that a load or the start excites and that the steps take out before they have lasted: what they would do to the responses.

Steps longer than about a third of a period keep the mean of a vibration and annihilate the rest within few steps, with every other long
step alike, so that runs with other steps agree about what they all have lost. The linearised motion tells it instead: a jump of the
accelerations by a, of their rate by a' or of a'' leaves in the mode i, of the angular frequency w and unit mass, beside what follows the
load

    -(a_i / w^2) cos w t,   -(a'_i / w^3) sin w t,   (a''_i / w^4) cos w t,     each times exp(-zeta w t),

of which the scheme keeps the part rho^n after n steps, rho being the spectral radius of its amplification matrix at w h. Added to the
states of the run, what is lost gives the responses as they would be with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.processes.one_thread import one_thread
from toolkit.foundation.spread import spread
from toolkit.responses.over_time.extremes import TimeKS, TimeMax, TimeMin
from toolkit.responses.response import Response
from toolkit.responses.stress.stress import StressResponse
from toolkit.responses.windows import steps_seen
from toolkit.sensitivity.errors.excited_modes import ExcitedModes, excited_modes
from toolkit.sensitivity.errors.kicks import FORCES, Kick, kicks, padded
from toolkit.sensitivity.errors.lost_derivatives import derivatives_of_modes
from toolkit.sensitivity.errors.numerical_damping import error_after, part_left
from toolkit.solvers.transient.scheme import generalized_alpha
from toolkit.system.solution import Solution

SLOW = 0.5
"""Angular frequency times step from which on the scheme begins to take out what vibrates."""
GONE = 0.5
"""Part of an amplitude that is left at the end, from which on runs with other steps tell the difference."""
FEW, LOOKED_AT = 40, 120
"""States in which responses are looked at with what is lost: whether it counts, and how much it is."""
LASTING = 3.0
"""Decays, of the logarithm of the amplitude, that a vibration lasts."""
FELT = 1e-3
"""Part of the motion of a body, or of its deformation, of velocities and of joint forces below which a vibration changes no response."""
WRONG = 0.05
"""Part of what is lost that a run which keeps it may be wrong by: 0.05 rad of its phase."""
MODES = 6
"""So many modes are looked at alone, the largest."""
COUNTS = 0.02
"""Part of the largest magnitude from which on what is lost of a response counts."""


class Lost(NamedTuple):
    """What one kick excites and steps take out, at some times: in every mode a cosine and a sine.

    Attributes
    ----------
    kick
        What excites it.
    modes
        Those that it excites.
    cosines, sines
        Modal amplitudes, (m,).
    passed
        Time since the kick, (n_t,).
    part
        Part of the amplitude that is lost, (n_t, m): nothing before the kick.
    """

    kick: Kick
    modes: ExcitedModes
    cosines: np.ndarray
    sines: np.ndarray
    passed: np.ndarray
    part: np.ndarray

    def states(self, turned: float, only: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Its q, v, a and multipliers, by the modes that `only` (m,) names, `turned` by a phase."""
        phase = np.outer(self.passed, self.modes.rates) + turned
        swing = self.cosines * np.cos(phase) + self.sines * np.sin(phase)
        rate = self.modes.rates * (self.sines * np.cos(phase) - self.cosines * np.sin(phase))
        q, v = swing * self.part * only, rate * self.part * only
        shapes = self.modes.shapes.T
        return q @ shapes, v @ shapes, -(q * self.modes.rates**2) @ shapes, q @ self.modes.forces.T

    def at(self, steps: np.ndarray) -> Lost:
        """The same at some of the times."""
        return self._replace(passed=self.passed[steps], part=self.part[steps])


class Vibration(NamedTuple):
    """One that steps take out.

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
    """What the vibrations that the steps have taken out would add to the responses.

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
    vibrations: list[Vibration]
    gradients: Callable[[], dict[str, dict[str, float]] | None]

    @property
    def told(self) -> str:
        """Them in words."""
        first = self.vibrations[0].rate / (2 * np.pi)
        many = (
            f"vibrations of {first:.4g} and more in a unit of time" if len(self.vibrations) > 1 else f"a vibration of {first:.4g}"
        )
        return many


@one_thread()
def lost_vibrations(solution: Solution, responses: Mapping[str, Response], scales: Mapping[str, float]) -> LostVibrations | None:
    """What a motion has lost; None if that is nothing which counts in any response, or is not known.

    Parameters
    ----------
    responses, scales : dict
        Name -> response, and its largest magnitude in the motion.
    """
    options = solution.options or solution.system.scene.solver
    if options.quasi_static or solution.run_times is not None or not solution.system.compiled or solution.steps < 2:
        return None
    looked = {name: each for name, each in responses.items() if scales.get(name, 0.0) > 0}
    try:
        seen = _at(solution, _looked_at(solution, looked, LOOKED_AT))
        lost = [found for kick in kicks(solution) if (found := _lost(solution, kick, seen.times)) is not None]
        sizes = [_sizes(seen, each) for each in lost]
        if not max((float(each.max(initial=0.0)) for each in sizes), default=0.0) > FELT:
            return None
        few = _looked_at(seen, looked, FEW)
        first = Comparison(_at(seen, few), [each.at(few) for each in lost], looked, scales)
        return _found(solution, Comparison(seen, lost, looked, scales), sizes) if first.counts else None
    except (ToolkitError, np.linalg.LinAlgError):
        return None


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


def _lost(solution: Solution, kick: Kick, times: np.ndarray) -> Lost | None:
    """What a kick excites, and what steps leave of it at some times; None if nothing vibrates."""
    system, options = solution.system, solution.options or solution.system.scene.solver
    q, v, _ = padded(solution, kick.state)
    terms = system.evaluate(system.inputs(solution.times[kick.state], FORCES), q, v, np.zeros(system.n))
    lengths = np.diff(solution.times)
    modes = excited_modes(system, terms, kick.jumps, SLOW / float(lengths[kick.state]))
    if not np.any(modes.damping < 1):
        return None
    w, (first, second, third) = modes.rates, modes.pushes
    kept = part_left(generalized_alpha(options.scheme, options.rho_inf), w, lengths[kick.state :])
    passed = np.maximum(times - kick.time, 0.0)
    after = np.searchsorted(solution.times, times) - kick.state
    left = np.where(after[:, None] > 0, 1 - kept[np.maximum(after, 0)], 0.0)
    fading = np.exp(-np.outer(passed, w * np.minimum(modes.damping, 1.0)))
    counting = np.where((modes.damping < 1) & (kept[-1] < GONE), 1.0, 0.0)
    return Lost(kick, modes, third / w**4 - first / w**2, -second / w**3, passed, left * fading * counting)


class Comparison:
    """Responses of a motion with what it has lost, and without.

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
        """Those of the responses."""
        return {name: float(np.real(each.value(solution))) for name, each in self.responses.items()}

    def errors(self, values: Mapping[str, float]) -> dict[str, float]:
        """Changes of the responses, parts of their largest magnitudes."""
        return {f: abs(value - self.own[f]) / self.scales[f] for f, value in values.items()}

    def vibrating(self, turned: float, only: list[np.ndarray]) -> Solution:
        """The motion with what is lost in some modes, by a phase later."""
        q, v, a, multipliers = self.seen.q, self.seen.v, self.seen.a, self.seen.multipliers
        for each, wanted in zip(self.lost, only, strict=True):
            more = each.states(turned, wanted)
            q, v, a, multipliers = q + more[0], v + more[1], a + more[2], multipliers + more[3]
        return replace(self.seen, q=q, v=v, a=a, multipliers=multipliers)

    @cached_property
    def with_all(self) -> dict[str, float]:
        """Values with all that is lost."""
        return self.values(self.vibrating(0.0, self.everything))

    @cached_property
    def swings(self) -> dict[str, float]:
        """Errors whatever the phase is."""
        return self._swings(self.errors(self.with_all), self.everything)

    def swing(self, kick: int, mode: int) -> float:
        """The largest that one mode makes."""
        only = [np.zeros_like(each) for each in self.everything]
        only[kick][mode] = 1.0
        return max(self._swings(self.errors(self.values(self.vibrating(0.0, only))), only).values())

    def _swings(self, errors: Mapping[str, float], only: list[np.ndarray]) -> dict[str, float]:
        turned = self.errors(self.values(self.vibrating(np.pi / 2, only)))
        return {f: float(np.hypot(errors[f], turned[f])) for f in errors}

    @property
    def counts(self) -> bool:
        """Whether any response is changed by what counts."""
        return max(self.swings.values(), default=0.0) > COUNTS


def _found(solution: Solution, compared: Comparison, sizes: list[np.ndarray]) -> LostVibrations | None:
    """What counts; None if nothing does."""
    if not compared.counts:
        return None
    largest = sorted(((size, k, i) for k, each in enumerate(sizes) for i, size in enumerate(each)), reverse=True)[:MODES]
    vibrations = []
    for _, k, i in largest:
        each, share = compared.lost[k], compared.swing(k, i)
        if share > COUNTS / 4:
            fading = float(each.modes.damping[i] * each.modes.rates[i])
            lasts = min(float(each.passed[-1]), LASTING / fading if fading > 0 else np.inf)
            vibrations.append(Vibration(float(each.modes.rates[i]), share, lasts))
    errors = compared.errors(compared.with_all)
    return (
        LostVibrations(compared.with_all, errors, compared.swings, sorted(vibrations), partial(_gradients, solution, compared))
        if vibrations
        else None
    )


def _sizes(seen: Solution, lost: Lost) -> np.ndarray:
    """How far each mode moves at most what it moves, (m,), in parts of how far the run moves coordinates of that kind, or is loaded."""
    ours = (seen.q - seen.q[0], seen.v, seen.multipliers)
    amplitude = np.hypot(lost.cosines, lost.sines) * lost.part.max(axis=0)
    theirs = (lost.modes.shapes * amplitude, lost.modes.shapes * amplitude * lost.modes.rates, lost.modes.forces * amplitude)
    found = np.zeros(len(amplitude))
    for group, place in _groups(seen):
        own, other = np.abs(ours[group][:, place]).max(initial=0.0), np.abs(theirs[group][place]).max(axis=0, initial=0.0)
        found = np.maximum(found, other / own if own > 0 else np.where(other > 0, np.inf, 0.0))
    return found


def _groups(solution: Solution) -> Iterator[tuple[int, np.ndarray | slice]]:
    """Which of q, v and multipliers, and the numbers of some: of every body the coordinates of its frame and those of its deformation."""
    system = solution.system
    for name, body in system.scene.all_bodies().items():
        first = system.numbering.first[name]
        last = min((start for start in system.numbering.first.values() if start > first), default=system.n_b)
        for place in (slice(first, first + body.frame_size), slice(first + body.frame_size, last)):
            if place.start < place.stop:
                yield 0, place
                yield 1, place
    if system.n > system.n_q:
        yield 2, slice(None)


def _gradients(solution: Solution, compared: Comparison) -> dict[str, dict[str, float]] | None:
    """What is lost of derivatives; None where the run has none of its states."""
    if not solution.system.n_x or solution.dq.shape[-1] != solution.system.n_x:
        return None
    states = compared.vibrating(0.0, compared.everything)
    vibrating = [replace(states, **_derivatives(solution, compared, at_peaks)) for at_peaks in (False, True)]
    names, found = solution.system.design.names, {}
    for f, each in compared.responses.items():
        slopes = each.evaluate(vibrating[_is_extreme(each)])[1] - each.evaluate(compared.seen)[1]
        found[f] = dict(zip(names, map(float, slopes), strict=True))
    return found


def _is_extreme(response: Response) -> bool:
    """Whether it looks for a peak over time."""
    return isinstance(response, TimeMax | TimeMin | TimeKS) or (isinstance(response, StressResponse) and response.when == "all")


def _derivatives(solution: Solution, compared: Comparison, at_peaks: bool) -> dict[str, Any]:
    """Derivatives of the states with what is lost."""
    found = {name: getattr(compared.seen, name) for name in ("dq", "dv", "da", "dmultipliers")}
    for each in compared.lost:
        changes = derivatives_of_modes(solution, each.kick, each.modes, each.passed, at_peaks)
        dq, dv, da = (change * each.part[..., None] for change in changes)
        shapes, forces = each.modes.shapes, each.modes.forces
        for name, basis, change in (("dq", shapes, dq), ("dv", shapes, dv), ("da", shapes, da), ("dmultipliers", forces, dq)):
            found[name] = found[name] + np.einsum("qm,tmx->tqx", basis, change)
    return found


def steps_that_keep(lost: LostVibrations, options: RunOptions, least: int, most: int) -> int | None:
    """So many steps, `least` or more, keep most of what is lost, with its phase; None if that takes more than `most`."""
    scheme, total = generalized_alpha(options.scheme, options.rho_inf), sum(each.share for each in lost.vibrations)
    steps = least
    while steps <= most:
        step = options.end_time / steps
        wrong = sum(each.share * error_after(scheme, each.rate, step, each.lasts) for each in lost.vibrations)
        if wrong <= WRONG * total:
            return steps
        steps = -(-5 * steps // 4)
    return None
