"""Whether a motion ends in a state about which vibrations have a meaning: at rest, or spinning as a whole at constant speed."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import first_largest
from toolkit.responses.vibrations.roots import Idle
from toolkit.solvers.spin.constancy import refuse_what_changes
from toolkit.solvers.spin.generator import Generator, angular_velocity, generator
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.solution import Solution

LEAST, ALONG = 0.1, 0.99
"""Part of what a motion lacks to a steady spin that moves the square of a root by all of it, at most; and the cosine between its vector and
the spin, from which on it is that."""
ALLOWED = 1e-3
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
    if left.max(initial=0) > ALLOWED:
        name = system.numbering.names[first_largest(left)]
        raise InputError(
            f"the motion does not end in an equilibrium, nor in a steady spin: {name} is still on its way by about {left.max():.1e} of the "
            "model size (or rad). Vibrations about such a state have no frequency. Let the motion come to rest (damping, a longer "
            "end_time, smaller steps: a spin needs a hundred in a turn), or ask for the equilibrium itself: ffrf statics, of a scene that "
            'spins with solver.equilibrium = "spinning".'
        )
    speed = float(np.sqrt(omega @ omega))
    if speed > ALLOWED * frequency:
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
    if not 0.0 < left <= ALLOWED * speed:
        return None
    turned = weights * motion.velocity(np.real(solution.q[-1]))

    def idle(s: complex, u: np.ndarray) -> bool:
        undecided = max(growth.max() / LEAST, (off.max() / LEAST) ** 2)
        size = float(np.linalg.norm(weights * u) * np.linalg.norm(turned))
        return abs(s) ** 2 <= undecided and float(abs(turned @ (weights * u))) >= ALONG * size

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
