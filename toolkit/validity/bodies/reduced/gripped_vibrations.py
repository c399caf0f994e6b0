"""By how much frequencies are too high because a basis leaves out shapes that move where joints and springs hold the body.

Its reduced model tells how far unit loads at rest move these shapes, the compliance C of `LeftOutShapes`. A vibration omega of unit modal
mass puts the amplitudes c on them, at the body's points and by its inertia, so that with the motions C c Rayleigh's quotient is

    omega_true^2 = omega^2 / (1 + x),    x = c^T C c / (omega^2 (1 - (omega / omega_l)^2))

where omega_l is the slowest vibration that is left out: as of springs in a row, one of which was rigid. Of free modes that a pin holds this
is true within 3 %, of some that a clamp holds it is up to 1.8 times too much.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.foundation.near_ties import first_largest
from toolkit.responses.pencil import Pencil, free_pencil, pencil_of, real_pencil
from toolkit.solvers.free_motions import is_symmetric
from toolkit.system.flexible_bodies import design_point
from toolkit.system.solution import Solution
from toolkit.validity.bodies.reduced.missed_statics import amplitudes_of_loads, softer_and_stressed

SMALL = 1e-6
"""Size of a vibration, in parts of the model size or rad, over which forces are linear in it to as much."""
NEAREST = 0.9
"""Part of the slowest frequency that is left out up to which its own inertia is counted."""


class Vibrating(NamedTuple):
    """A vibration of unit modal mass: rad per time, coordinates (n_q,) and multipliers."""

    omega: float
    shape: np.ndarray
    multipliers: np.ndarray


def raised_by_grips(
    solution: Solution, frequencies: Mapping[str, float], slowest: Mapping[str, float]
) -> dict[str, float] | None:
    """Parts by which frequencies about the last state are too high, by what they are called; None where that is not known.

    Parameters
    ----------
    frequencies
        In cycles per time; each is that of the vibration which is nearest to it.
    slowest
        Body -> the slowest frequency that its basis leaves out.
    """
    system, n_q = solution.system, solution.system.n_q
    pencil = real_pencil(pencil_of(solution))
    Z, reduced = free_pencil(system.weights[:n_q], pencil)
    known = all(design_point(system.scene, each, "left_out_shapes").model.left_out_shapes is not None for each in slowest)
    if solution.spins or not known or not is_symmetric(reduced.stiffness):
        return None
    squares, shapes = scipy.linalg.eigh(*((each + each.T) / 2 for each in (reduced.stiffness, reduced.mass)))
    rates = np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)
    found = {}
    for name, frequency in frequencies.items():
        k = first_largest(-np.abs(rates - frequency))
        vibrating = _whole(pencil, n_q, 2 * np.pi * float(rates[k]), Z @ shapes[:, k])
        softer = sum(_softer(solution, body, vibrating, frequency / least) for body, least in slowest.items())
        found[name] = float(np.sqrt(1 + softer) - 1)
    return found


def _whole(pencil: Pencil, n_q: int, omega: float, shape: np.ndarray) -> Vibrating:
    left = (pencil.stiffness - omega**2 * pencil.mass)[:n_q, :n_q] @ shape
    return Vibrating(omega, shape, np.linalg.lstsq(pencil.stiffness[n_q:, :n_q].T, -left)[0])


def _softer(solution: Solution, body: str, vibrating: Vibrating, near: float) -> float:
    """x of one body; `near` is the frequency in parts of the slowest that is left out."""
    design = design_point(solution.system.scene, body, "left_out_shapes")
    assert design.model.left_out_shapes is not None
    loads = _amplitudes(solution, body, vibrating)
    compliance = softer_and_stressed(design_point(solution.system.scene, body))[0] * design.model.left_out_shapes.compliance
    return float(loads @ compliance @ loads) / (vibrating.omega**2 * (1 - min(near, NEAREST) ** 2))


def _amplitudes(solution: Solution, body: str, vibrating: Vibrating) -> np.ndarray:
    """Loads c of a body per unit of a vibration, by the states at both of its ends."""
    system, n_q = solution.system, solution.system.n_q
    size = SMALL / np.abs(system.weights[:n_q] * vibrating.shape).max()
    side = np.array([[size], [-size]])
    options = (solution.options or system.scene.solver).model_copy(update={"quasi_static": False})
    states = {
        "q": solution.q[-1] + side * vibrating.shape,
        "v": np.zeros((2, n_q)),
        "a": -(vibrating.omega**2) * side * vibrating.shape,
        "multipliers": solution.multipliers[-1] + side * vibrating.multipliers,
    }
    ends = replace(solution, times=np.repeat(solution.times[-1:], 2), options=options, **states)
    one, other = amplitudes_of_loads(ends, body, np.arange(2))
    found: np.ndarray = (one - other) / (2 * size)
    return found
