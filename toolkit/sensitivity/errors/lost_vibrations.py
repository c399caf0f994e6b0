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
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
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
LOOKED_AT = 120
"""States in which responses are looked at with what is lost."""
FELT = 1e-3
"""Part of the motion of a body, or of its deformation, of velocities and of joint forces below which a vibration changes no response."""
WRONG = 0.1
"""Part of what is lost that a run which keeps it may be wrong by: 0.1 rad of its phase."""
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
    try:
        seen = _looked_at(solution, responses)
        lost = [found for kick in kicks(solution) if (found := _lost(solution, kick, seen.times)) is not None]
        return _of_responses(solution, seen, lost, responses, scales) if lost else None
    except (ToolkitError, np.linalg.LinAlgError):
        return None


def _looked_at(solution: Solution, responses: Mapping[str, Response]) -> Solution:
    """The motion at some of its times, among them the first ones and those that responses name."""
    last = len(solution.times) - 1
    if last <= LOOKED_AT:
        return solution
    named = [step for each in responses.values() for step in steps_seen(each, solution.times)]
    steps = np.unique([*range(LOOKED_AT // 4), *spread(last, LOOKED_AT), *named])
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
    vibrates = np.where(modes.damping < 1, 1.0, 0.0)
    return Lost(kick, modes, third / w**4 - first / w**2, -second / w**3, passed, left * fading * vibrates)


def _of_responses(
    solution: Solution, seen: Solution, lost: list[Lost], responses: Mapping[str, Response], scales: Mapping[str, float]
) -> LostVibrations | None:
    """What is lost of every response; None if none of it counts."""
    sizes = [_sizes(seen, each) for each in lost]
    if not max((float(each.max(initial=0.0)) for each in sizes), default=0.0) > FELT:
        return None
    names = [name for name in responses if scales.get(name, 0.0) > 0]
    own = _values(seen, responses, names)

    def changes(turned: float, only: list[np.ndarray]) -> tuple[dict[str, float], dict[str, float]]:
        values = _values(_with(seen, lost, turned, only), responses, names)
        return values, {f: abs(values[f] - own[f]) / scales[f] for f in names}

    def swings(only: list[np.ndarray]) -> dict[str, float]:
        (_, one), (_, other) = changes(0.0, only), changes(np.pi / 2, only)
        return {f: float(np.hypot(one[f], other[f])) for f in names}

    everything = [np.ones(len(each)) for each in sizes]
    values, errors = changes(0.0, everything)
    swung = swings(everything)
    if not max(swung.values(), default=0.0) > COUNTS:
        return None
    largest = sorted(((size, k, i) for k, each in enumerate(sizes) for i, size in enumerate(each)), reverse=True)[:MODES]
    found = []
    for _, k, i in largest:
        only = [np.where((np.arange(len(each)) == i) & (n == k), 1.0, 0.0) for n, each in enumerate(sizes)]
        share = max(swings(only).values())
        if share > COUNTS / 4:
            found.append(Vibration(float(lost[k].modes.rates[i]), share, _lasts(seen, lost[k], i)))
    return LostVibrations(values, errors, swung, sorted(found), partial(_gradients, solution, seen, lost, responses))


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


def _lasts(seen: Solution, lost: Lost, mode: int) -> float:
    """Time that a vibration lasts: until the end, or until a twentieth is left."""
    fading = float(lost.modes.damping[mode] * lost.modes.rates[mode])
    return min(float(lost.passed[-1]), 3 / fading if fading > 0 else np.inf)


def _values(solution: Solution, responses: Mapping[str, Response], names: list[str]) -> dict[str, float]:
    return {name: float(np.real(responses[name].value(solution))) for name in names}


def _with(seen: Solution, lost: list[Lost], turned: float, only: list[np.ndarray]) -> Solution:
    """The motion with what is lost."""
    q, v, a, multipliers = seen.q, seen.v, seen.a, seen.multipliers
    for each, wanted in zip(lost, only, strict=True):
        more = each.states(turned, wanted)
        q, v, a, multipliers = q + more[0], v + more[1], a + more[2], multipliers + more[3]
    return replace(seen, q=q, v=v, a=a, multipliers=multipliers)


def _gradients(
    solution: Solution, seen: Solution, lost: list[Lost], responses: Mapping[str, Response]
) -> dict[str, dict[str, float]] | None:
    """What is lost of derivatives; None where the run has none of its states."""
    if not solution.system.n_x or solution.dq.shape[-1] != solution.system.n_x:
        return None
    states = _with(seen, lost, 0.0, [np.ones(len(each.modes.rates)) for each in lost])
    vibrating = [replace(states, **_derivatives(solution, seen, lost, at_peaks)) for at_peaks in (False, True)]
    names = solution.system.design.names
    slopes = {f: each.evaluate(vibrating[_is_extreme(each)])[1] - each.evaluate(seen)[1] for f, each in responses.items()}
    return {f: dict(zip(names, map(float, each), strict=True)) for f, each in slopes.items()}


def _is_extreme(response: Response) -> bool:
    """Whether it looks for a peak over time."""
    return isinstance(response, TimeMax | TimeMin | TimeKS) or (isinstance(response, StressResponse) and response.when == "all")


def _derivatives(solution: Solution, seen: Solution, lost: list[Lost], at_peaks: bool) -> dict[str, Any]:
    """Derivatives of the states with what is lost."""
    found = {name: getattr(seen, name) for name in ("dq", "dv", "da", "dmultipliers")}
    for each in lost:
        changes = derivatives_of_modes(solution, each.kick, each.modes, each.passed, at_peaks)
        dq, dv, da = (change * each.part[..., None] for change in changes)
        shapes, forces = each.modes.shapes, each.modes.forces
        for name, basis, change in (("dq", shapes, dq), ("dv", shapes, dv), ("da", shapes, da), ("dmultipliers", forces, dq)):
            found[name] = found[name] + np.einsum("qm,tmx->tqx", basis, change)
    return found


def steps_that_keep(lost: LostVibrations, options: RunOptions, most: int) -> int | None:
    """So many steps keep most of what is lost, with its phase; None if that takes more than `most`."""
    scheme, total = generalized_alpha(options.scheme, options.rho_inf), sum(each.share for each in lost.vibrations)
    steps = 2 * int(np.ceil(options.end_time / options.step))
    while steps <= most:
        step = options.end_time / steps
        wrong = sum(each.share * error_after(scheme, each.rate, step, each.lasts) for each in lost.vibrations)
        if wrong <= WRONG * total:
            return steps
        steps = -(-5 * steps // 4)
    return None
