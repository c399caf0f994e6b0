"""The critical speed of a flexible body that spins: linear FFRF lacks centrifugal stiffening and diverges beyond it.

In a frame that spins at omega about an axis the linear body feels K q_f - omega^2 C q_f, with the mass C that moves across the axis (in
the plane all of it): it is stable as long as this matrix is positive definite, that is, as omega is below the lowest frequency of such
motions of the body held by its frame.

    C = sum_a Q[a, a] - sum_ab n_a n_b Q[a, b]        elastic rows and columns, n: unit vector of the axis in the body

Of a body that its spin stiffens, sum_ab n_a n_b S[a, b] is taken from it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from toolkit.foundation.near_ties import first_largest
from toolkit.reduced_model.parts import stiffness_of_spin
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import deforming, flexible_body, spins_of
from toolkit.system.solution import Solution

FAST = 0.5
"""Part of its critical speed from which on a spin may be why a run failed."""


def spinning_bodies(scene: ResolvedScene) -> list[str]:
    """Names of the flexible bodies whose frame can turn."""
    return [name for name, body in deforming(scene).items() if body.turns]


def critical_speed(scene: ResolvedScene, body: str, axis: np.ndarray | None = None, stiffened: bool = True) -> float:
    """The speed of the body's frame, in rad/time, beyond which the linear body is unstable.

    Parameters
    ----------
    axis : direction (3,) in the axes of the reduced model, of a body in space; by default that of a turning frame, or of the angular
        velocity at the start, or the most critical of the three axes of the model
    stiffened : whether with the stiffening that the body asks for
    """
    given = [axis] if axis is not None else _likely_axes(scene, body)
    return min(_critical(scene, body, each, stiffened) for each in given)


def _critical(scene: ResolvedScene, body: str, axis: np.ndarray, stiffened: bool) -> float:
    stiffness, mass = _scaled(scene, body, axis, stiffened)
    last = len(mass) - 1  # the largest eigenvalue of K^-1 C is exact, where the smallest of C^-1 K would drown in round-off
    largest = float(scipy.linalg.eigh(mass, stiffness, eigvals_only=True, subset_by_index=[last, last])[0])
    return float(1 / np.sqrt(largest)) if largest > 0 else np.inf


def _likely_axes(scene: ResolvedScene, body: str) -> list[np.ndarray]:
    found = flexible_body(scene, body)
    if found.only_axis is not None:
        return [found.only_axis]
    spin = np.real(found.start_spin)
    return [spin] if np.any(spin) else list(np.eye(3))


def too_fast_at_start(scene: ResolvedScene) -> Iterator[tuple[str, float, float]]:
    """Bodies that the scene starts beyond their critical speed, how fast, and the critical speed about that axis."""
    for body in spinning_bodies(scene):
        spin = np.real(flexible_body(scene, body).start_spin)
        if not _stable(scene, body, spin):
            yield body, float(np.linalg.norm(spin)), critical_speed(scene, body, spin)


def too_fast_in_motion(solution: Solution) -> Iterator[tuple[str, float, float]]:
    """Bodies that exceed their critical speed where they spin fastest, with that speed and the critical one about the axis then."""
    scene = solution.system.scene
    for body in spinning_bodies(scene):
        spins = spins_of(solution, body)
        spin = spins[first_largest(np.linalg.norm(spins, axis=1))]
        if not _stable(scene, body, spin):
            yield body, float(np.linalg.norm(spin)), critical_speed(scene, body, spin)


def fast_bodies(solution: Solution) -> list[str]:
    """Flexible bodies whose frame spins with `FAST` of its critical speed or more at any time."""
    scene = solution.system.scene
    spins = {body: spins_of(solution, body) for body in spinning_bodies(scene)}
    fastest = {body: each[first_largest(np.linalg.norm(each, axis=1))] for body, each in spins.items()}
    return [body for body, spin in fastest.items() if not _stable(scene, body, spin / FAST)]


def _stable(scene: ResolvedScene, body: str, spin: np.ndarray) -> bool:
    """Whether K - omega^2 C is positive definite; far cheaper than the critical speed itself."""
    speed = float(np.linalg.norm(spin))
    if speed == 0:
        return True
    stiffness, mass = _scaled(scene, body, spin)
    try:
        np.linalg.cholesky(stiffness - speed**2 * mass)
    except np.linalg.LinAlgError:
        return False
    return True


def _scaled(scene: ResolvedScene, body: str, axis: np.ndarray, stiffened: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """K, scaled to a unit diagonal, and C for an axis of any length in the same scale, (n_f, n_f)."""
    found, unit = flexible_body(scene, body), axis / np.linalg.norm(axis)
    inv, stiffening = found.invariants(scene), found.stiffening(scene)
    mass, stiffness = np.real(inv.mass_across(unit)), np.real(inv.stiffness)
    if stiffened and stiffening is not None:
        mass = mass - stiffness_of_spin(np.real(stiffening), unit)
    scale = 1 / np.sqrt(np.diag(stiffness))
    return scale[:, None] * stiffness * scale, scale[:, None] * mass * scale
