"""Check that a spinning scene is the same at every angle: only then is its steady state one, and its small motions have modes."""

from __future__ import annotations

import numpy as np

from toolkit.equations.equations import Inputs
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.free_motions import free_motions
from toolkit.solvers.spin.generator import Generator
from toolkit.solvers.spin.state import Linearised, balancing, linearised
from toolkit.system.system import System

ANGLES = (1.0, 2.3)
"""Angles in rad to turn the state by: no multiples of a turn's half, third or quarter."""
CHANGES = 1e-7
"""Largest change of forces with the angle, in parts of the largest one or of the centrifugal one at the model size, and of
stiffness, damping and mass in parts of their largest: round-off of stiff bodies is smaller, a rotor that is worth the word is
less round."""


def refuse_what_changes(system: System, inputs: Inputs, motion: Generator, speed: float, q: np.ndarray) -> None:
    """Turn the whole state, and compare forces and linearised equations in the frame that turns with it.

    Raises
    ------
    InputError
        Loads, springs to the ground or bodies that do not turn make a difference; names the coordinate.
    """
    if speed == 0:
        return
    n_q, weights = system.n_q, system.weights[: system.n_q]
    q, real = np.real(q), Generator(np.real(motion.matrix), np.real(motion.offset))
    here, largest = _balanced(system, inputs, real, q)
    free = free_motions(here.by_acc[:n_q, n_q:].T, weights)
    own = _reduced(here, real, free, free)
    inertia = speed**2 * float((np.abs(here.by_acc[:n_q, :n_q]) / np.outer(weights, weights)).max())  # at the model size
    for angle in ANGLES:
        there, turn = real.turned(q, angle / speed)
        state, _ = _balanced(system, inputs, real, there)
        change = turn.T @ state.residual[:n_q] - here.residual[:n_q]
        if (np.abs(change) / weights).max(initial=0) > CHANGES * max(inertia, largest):
            _refuse(system, change, angle, "the forces on")
        for one, other, scale in zip(own, _reduced(state, real, turn @ free, turn @ free), _scales(own), strict=True):
            apart = np.abs(other - one)
            if apart.max(initial=0) > CHANGES * scale:
                _refuse(system, weights**2 * free[:, int(np.argmax(apart.max(axis=0)))], angle, "the linearised equations of")


def _balanced(system: System, inputs: Inputs, motion: Generator, q: np.ndarray) -> tuple[Linearised, float]:
    """State that turns, with the joint forces that balance it best, and the largest force that they have to balance."""
    n_q, pad = system.n_q, np.zeros(system.n - system.n_q)
    loose = linearised(system, inputs, q, motion.velocity(q), np.append(motion.acceleration(q), pad))
    found = balancing(system, loose.by_acc[:n_q, n_q:], loose.residual[:n_q])
    state = linearised(system, inputs, q, motion.velocity(q), np.append(motion.acceleration(q), found))
    return state, float((np.abs(loose.residual[:n_q]) / system.weights[:n_q]).max())


def _reduced(state: Linearised, motion: Generator, left: np.ndarray, right: np.ndarray) -> list[np.ndarray]:
    n_q = len(left)
    return [left.T @ each[:n_q, :n_q] @ right for each in state.spinning(motion.matrix)]


def _scales(own: list[np.ndarray]) -> list[float]:
    stiffness, damping, mass = (float(np.abs(each).max(initial=0)) for each in own)
    return [stiffness, max(damping, float(np.sqrt(stiffness * mass))), mass]


def _refuse(system: System, change: np.ndarray, angle: float, what: str) -> None:
    name = system.numbering.names[first_largest(np.abs(change) / system.weights[: system.n_q])]
    raise InputError(
        f"the scene is not the same at every angle of its spin: {angle:g} rad further {what} {name} are other ones, as under a weight "
        "across the axis, on springs to the ground off the axis, or where a part that spins without being round is held by one that does "
        "not. Such a scene has no steady state and no modes: simulate it."
    )
