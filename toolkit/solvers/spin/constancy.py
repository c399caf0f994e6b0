"""Whether a scene that spins is the same at every angle: only then is its steady state one, and its small motions have modes."""

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
"""In rad: no multiples of a turn's half, third or quarter."""
CHANGES = 1e-7
"""Part of the largest force, or of the largest stiffness, damping and mass, by which they may change with the angle: round-off of stiff
bodies is smaller, a rotor that is worth the word is less round."""


def refuse_what_changes(
    system: System, inputs: Inputs, motion: Generator, speed: float, q: np.ndarray, multipliers: np.ndarray
) -> None:
    """Turn the whole state, and compare forces and linearised equations in the frame that turns with it.

    Raises
    ------
    InputError
        Loads, springs to the ground or bodies that do not turn make a difference; names the coordinate.
    """
    if speed == 0:
        return
    n_q = system.n_q
    q, multipliers = np.real(q), np.real(multipliers)
    here = _at(system, inputs, motion, q, multipliers)
    free = free_motions(np.real(here.by_acc[:n_q, n_q:].T), system.weights[:n_q])
    own = _reduced(here, motion, free, free)
    for angle in ANGLES:
        there, turn = motion.turned(q, angle / speed)
        loose = _at(system, inputs, motion, there, 0 * multipliers)
        found = balancing(system, loose.by_acc[:n_q, n_q:], loose.residual[:n_q])
        state = _at(system, inputs, motion, there, found)
        left = np.abs(state.residual[:n_q]) / system.weights[:n_q]
        terms = np.abs(state.by_acc[:n_q]) @ np.abs(np.append(motion.acceleration(there), found)) / system.weights[:n_q]
        if left.max(initial=0) > CHANGES * max(terms.max(initial=0), np.abs(loose.residual[:n_q] / system.weights[:n_q]).max()):
            _refuse(system, turn.T @ state.residual[:n_q], angle, "the forces on")
        for one, other, scale in zip(own, _reduced(state, motion, turn @ free, turn @ free), _scales(own), strict=True):
            change = np.abs(other - one)
            if change.max(initial=0) > CHANGES * scale:
                _refuse(system, free[:, int(np.argmax(change.max(axis=0)))], angle, "the linearised equations of")


def _at(system: System, inputs: Inputs, motion: Generator, q: np.ndarray, multipliers: np.ndarray) -> Linearised:
    found = linearised(system, inputs, q, motion.velocity(q), np.append(motion.acceleration(q), multipliers))
    return Linearised(*(np.real(each) for each in found))


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
