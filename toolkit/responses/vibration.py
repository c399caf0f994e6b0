"""Frequencies and damping of the vibrations about an equilibrium, about a steady spin, and about the end of a motion that is one of both.

With the static residual's derivative K (by q and lam), the mass M and the damping C, the latter two without multipliers, a vibration is

    (s^2 M + s C + K) u = 0,     w^T (s^2 M + s C + K) = 0
    ds = - w^T (s^2 dM + s dC + dK) u / w^T (2 s M + C) u

About a spin the matrices are those of `solvers.spin.state.Linearised.spinning`.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

import numpy as np
from pydantic import Field

from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import first_largest
from toolkit.responses.pencil import (
    REPEATED_ROOTS,
    Idle,
    Pencil,
    all_vibrations,
    find_vibration,
    pencil_change,
    pencil_of,
    real_pencil,
    spinning_change,
    spinning_pencil,
)
from toolkit.responses.response import Partials, Response
from toolkit.solvers.free_motions import felt_state
from toolkit.solvers.spin_axis import Generator, angular_velocity, generator, refuse_what_changes
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.solution import Solution

SPIN_ROOT_PART, SPIN_COSINE = 0.1, 0.99
"""Part of what a motion lacks to a steady spin that moves the square of a root by all of it, at most; and the cosine between its vector and
the spin, from which on it is that."""
VIBRATION_LEFT = 1e-3
"""Vibration left at a motion's end, in parts of the model size (or rad): frequencies change by about as much."""


def refuse_unsteady(solution: Solution, frequency: float) -> None:
    """Refuse an end state that is neither at rest nor a steady spin.

    Velocities and accelerations that are off those of a spin, v = S q + s and a = S v, belong to motions of the sizes |v| / omega
    and |a| / omega^2 at least.

    Parameters
    ----------
    frequency
        omega of the vibration that is asked for, in rad/time.

    Raises
    ------
    InputError
        Names what moves most, and by how much.
    """
    system, q = solution.system, np.real(solution.q[-1])
    omega, motion, off, growth = _beside_a_spin(solution)
    left = np.maximum(off / frequency, growth / frequency**2)
    if left.max(initial=0) > VIBRATION_LEFT:
        name = system.numbering.names[first_largest(left)]
        raise InputError(
            f"the motion does not end in an equilibrium, nor in a steady spin: {name} is still on its way by about {left.max():.1e} of the "
            "model size (or rad). Vibrations about such a state have no frequency. Let the motion come to rest (damping, a longer "
            "end_time, smaller steps: a spin needs a hundred in a turn), or ask for the equilibrium itself: ffrf statics, of a scene that "
            'spins with solver.equilibrium = "spinning".'
        )
    speed = float(np.sqrt(omega @ omega))
    if speed > VIBRATION_LEFT * frequency:
        inputs = system.inputs(solution.times[-1], LEVELS)
        refuse_what_changes(system, inputs, motion, speed, q)


def free_spin(solution: Solution) -> Idle | None:
    """Test that tells a free spin's roots from vibrations at the end of a motion; None where it does not spin.

    Such a spin has s^2 = 0: it may be turned further, and any speed of it stays. What the motion lacks to a steady one, the accelerations
    a - S v of the size d, leaves anything up to d of s^2, growing or not. A root of that size whose vector is the spin itself is zero.
    """
    if not solution.steps:
        return None
    omega, motion, off, growth = _beside_a_spin(solution)
    speed = float(np.sqrt(omega @ omega))
    weights, left = (
        solution.system.weights[: solution.system.n_q],
        max(off.max(initial=0.0), growth.max(initial=0.0) / max(speed, 1e-300)),
    )
    if not 0.0 < left <= VIBRATION_LEFT * speed:
        return None
    turned = weights * motion.velocity(np.real(solution.q[-1]))

    def idle(s: complex, u: np.ndarray) -> bool:
        undecided = max(growth.max() / SPIN_ROOT_PART, (off.max() / SPIN_ROOT_PART) ** 2)
        size = float(np.linalg.norm(weights * u) * np.linalg.norm(turned))
        return abs(s) ** 2 <= undecided and float(abs(turned @ (weights * u))) >= SPIN_COSINE * size

    return idle


def _beside_a_spin(solution: Solution) -> tuple[np.ndarray, Generator, np.ndarray, np.ndarray]:
    """Mean angular velocity at the end, the spin with it, and weighted deviations (n_q,) of velocities and accelerations."""
    system, q, v, a = solution.system, *(np.real(each[-1]) for each in (solution.q, solution.v, solution.a))
    weights, omega = system.weights[: system.n_q], angular_velocity(system, q, v)
    motion = generator(system, omega, np.zeros(system.scene.dimension))
    motion = Generator(motion.matrix, motion.offset + _translation(solution, v - motion.velocity(q)))
    return omega, motion, weights * np.abs(v - motion.velocity(q)), weights * np.abs(a - motion.acceleration(q))


def _translation(solution: Solution, off: np.ndarray) -> np.ndarray:
    """Mean velocity of all frames' origins as velocities (n_q,): the spin's centre need not be the scene's origin."""
    system = solution.system
    bodies = {name: system.scene.body(name) for name in system.scene.pieces()}
    origins = [system.numbering.first[name] + np.arange(body.moves) for name, body in bodies.items() if body.moves]
    found = np.zeros(system.n_q)
    if origins:
        mean = np.mean([off[at] for at in origins], axis=0)
        for at in origins:
            found[at] = mean
    return found


def any_pencil_of(solution: Solution) -> Pencil:
    """Stiffness, damping and mass of the state that a solution ends in, at rest or spinning."""
    return spinning_pencil(solution) if solution.spins or solution.steps else pencil_of(solution)


class OfVibration(Response):
    """Base of responses of one vibration about an equilibrium.

    Attributes
    ----------
    number
        Which one, from the slowest on.
    when
        "end" asks for it at the end of a motion too, where the motion has come to rest or to a steady spin; any other end is refused.
        Left out, it is one of statics alone.
    """

    number: int = Field(default=1, ge=1, strict=True)
    when: Literal["end"] | None = None

    @property
    def needs_rest(self) -> bool:
        """Whether the response exists for an equilibrium only: true unless it is asked for at the end of a motion."""
        return self.when is None

    @abstractmethod
    def counted(self, damping: np.ndarray) -> np.ndarray:
        """Damping matrix (n, n) that this response takes into account."""

    @abstractmethod
    def of(self, s: complex) -> float:
        """Value of the response from s; nan where s is no vibration that counts."""

    def slowness(self, s: complex) -> float:
        """Size |s| by which vibrations are numbered; nan where s does not count."""
        return abs(s) if np.isfinite(self.of(s)) else np.nan

    @abstractmethod
    def slope(self, s: complex, ds: np.ndarray) -> np.ndarray:
        """Derivative (...,) of the response, real, from the derivative `ds` (...,) of s, complex."""

    def partials(self, solution: Solution) -> Partials:
        """Value and partial derivatives of the response for the vibration of the wanted number.

        Raises
        ------
        InputError
            There are not so many; or it is a motion that does not end in an equilibrium; or a load has an integral over time, which
            undamped vibrations do not have.
        SingularSystemError
            The joints leave no motion.
        """
        if solution.spins or solution.steps:
            return self._of_a_state_that_moves(solution)
        system, damped = solution.system, bool(np.any(self.counted(np.ones((1, 1)))))
        whole = any_pencil_of(solution)
        felt = felt_state(system, whole.stiffness)
        if felt and not damped:
            raise InputError(
                f"{felt} is an integral over time, which undamped vibrations do not have. Ask for "
                "the response damping-ratio instead, or leave the integral out."
            )
        pencil = self.counting(solution, whole)
        found = find_vibration(system.weights[: system.n_q], real_pencil(pencil), self.number, self.slowness)
        s, u, w = found.s, found.right, found.left
        if not found.alone:
            return self._one_of_two(solution, s)
        step = Pencil(*(np.imag(each) for each in pencil))
        moved = s * s * step.mass + s * step.damping + step.stiffness
        value = self.of(s) + 1j * self.slope(s, -(w @ moved @ u) / found.scale)
        changes = pencil_change(solution, s, u, w, damped=damped)
        by_z, design = (self.slope(s, -each / found.scale) for each in changes)
        n_q = system.n_q
        return Partials(value.real if system.compiled else value, q=by_z[None, :n_q], multipliers=by_z[None, n_q:], design=design)

    def counting(self, solution: Solution, pencil: Pencil) -> Pencil:
        """Pencil with the damping that counts: about a spin, and at the end of a motion, all of it."""
        moves = solution.spins or solution.steps
        return pencil if moves else pencil._replace(damping=self.counted(pencil.damping))

    def vibrations(self, solution: Solution, pencil: Pencil, weights: np.ndarray) -> np.ndarray:
        """Roots s of all vibrations that count, with a pencil about this state, from the slowest on.

        Parameters
        ----------
        weights : (n_q,)
            What makes coordinates of the pencil comparable.
        """
        return all_vibrations(weights, real_pencil(self.counting(solution, pencil)), self.slowness, free_spin(solution))

    def _of_a_state_that_moves(self, solution: Solution) -> Partials:
        """Value and partial derivatives about a steady spin or at the end of a motion, with dampers, in the frame that spins."""
        system, pencil = solution.system, any_pencil_of(solution)
        weights, idle = system.weights[: system.n_q], free_spin(solution)
        found = find_vibration(weights, real_pencil(pencil), self.number, self.slowness, idle)
        s, u, w = found.s, found.right, found.left
        if solution.steps and system.compiled and s:
            refuse_unsteady(solution, abs(s))
        if not found.alone:
            return self._one_of_two(solution, s)
        step = Pencil(*(np.imag(each) for each in pencil))
        moved = -(w @ (s * s * step.mass + s * step.damping + step.stiffness) @ u) / found.scale
        value = self.of(s) + 1j * self.slope(s, moved)
        by = {name: self.slope(s, -each / found.scale) for name, each in spinning_change(solution, s, u, w)._asdict().items()}
        design, last = by.pop("design"), len(solution.times) - 1
        states = {name: np.pad(each[None], ((last, 0), (0, 0))) for name, each in by.items()}
        return Partials(value.real if system.compiled else value, **states, design=design)

    def _one_of_two(self, solution: Solution, s: complex) -> Partials:
        """Value of a vibration with a double root, whose derivatives are nan: which of both vibrations it is stays open."""
        value = self.of(s) if solution.system.compiled else complex(self.of(s), np.nan)
        return Partials(value, design=np.full(solution.system.n_x, np.nan))


class Frequency(OfVibration):
    """Frequency of a vibration about an equilibrium, in cycles per time: those of `ffrf modes`. Negative where the equilibrium is unstable;
    motions that nothing holds have zero, each once. About an equilibrium at rest it is without dampers; about a steady spin, and at
    the end of a motion, it is with dampers, seen from the frame that spins.
    """

    kind = "frequency"
    quantity = "rate"

    def counted(self, damping: np.ndarray) -> np.ndarray:
        """Zero matrix: frequencies about an equilibrium at rest are without damping."""
        return 0 * damping

    def of(self, s: complex) -> float:
        """Frequency from Im s of a pair of roots, or - Re s where it is real; one of each pair."""
        vibrates = abs(s.imag) > REPEATED_ROOTS * abs(s)
        one = s.imag if vibrates else s.real
        return (one if vibrates else 0.0 - one) / (2 * np.pi) if one >= 0 else np.nan

    def slowness(self, s: complex) -> float:
        """Frequency, by which vibrations are numbered, so that what is unstable comes first."""
        return self.of(s)

    def slope(self, s: complex, ds: np.ndarray) -> np.ndarray:
        """Derivative of the frequency from the derivative `ds` of s."""
        return (np.imag(ds) if abs(s.imag) > REPEATED_ROOTS * abs(s) else -np.real(ds)) / (2 * np.pi)


class DampingRatio(OfVibration):
    """Damping of a vibration about an equilibrium, in parts of the critical one: - Re s / |s|. What is damped more than critically does not
    vibrate and is not counted.
    """

    kind = "damping-ratio"
    quantity = "none"

    def counted(self, damping: np.ndarray) -> np.ndarray:
        """Damping matrix as it is: all damping counts."""
        return damping

    def of(self, s: complex) -> float:
        """Damping ratio - Re s / |s| of one root of each pair."""
        return -s.real / abs(s) if s.imag > REPEATED_ROOTS * abs(s) else np.nan

    def slope(self, s: complex, ds: np.ndarray) -> np.ndarray:
        """Derivative of the damping ratio from the derivative `ds` of s."""
        return -np.real(ds) / abs(s) + s.real * np.real(np.conj(s) * ds) / abs(s) ** 3
