"""Whether a motion ends in a state about which vibrations have a meaning: at rest, or spinning as a whole at constant speed."""

from __future__ import annotations

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.spin.constancy import refuse_what_changes
from toolkit.solvers.spin.generator import Generator, angular_velocity, generator
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.solution import Solution

ALLOWED = 1e-3
"""What a motion may still vibrate by at its end, in parts of the scene's size (or rad): frequencies change by about as much."""


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
    system, q, v, a = solution.system, *(np.real(each[-1]) for each in (solution.q, solution.v, solution.a))
    weights, omega = system.weights[: system.n_q], angular_velocity(system, q, v)
    still = np.zeros(system.scene.dimension)
    motion = generator(system, omega, still)
    motion = Generator(motion.matrix, motion.offset + _translation(solution, v - motion.velocity(q)))
    left = np.maximum(np.abs(v - motion.velocity(q)) / frequency, np.abs(a - motion.acceleration(q)) / frequency**2) * weights
    if left.max(initial=0) > ALLOWED:
        name = system.numbering.names[first_largest(left)]
        raise InputError(
            f"the motion does not end in an equilibrium, nor in a steady spin: {name} is still on its way by about {left.max():.1e} of the "
            "scene's size (or rad). Vibrations about such a state have no frequency. Let the motion come to rest (damping, a longer "
            "end_time, smaller steps: a spin needs a hundred in a turn), or ask for the equilibrium itself: ffrf statics, of a scene that "
            'spins with solver.equilibrium = "spinning".'
        )
    speed = float(np.sqrt(omega @ omega))
    if speed > ALLOWED * frequency:
        inputs = system.inputs(solution.times[-1], LEVELS)
        refuse_what_changes(system, inputs, motion, speed, q)


def _translation(solution: Solution, off: np.ndarray) -> np.ndarray:
    """Velocities (n_q,) of all frames' origins by their mean: the spin's centre need not be the scene's origin."""
    system = solution.system
    bodies = {name: system.scene.body(name) for name in system.scene.pieces()}
    origins = [system.numbering.first[name] + np.arange(body.moves) for name, body in bodies.items() if body.moves]
    found = np.zeros(system.n_q)
    if origins:
        mean = np.mean([off[at] for at in origins], axis=0)
        for at in origins:
            found[at] = mean
    return found
