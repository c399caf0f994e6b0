"""The critical speed of a flexible body that spins: linear FFRF lacks centrifugal stiffening and diverges beyond it.

In a frame that spins at omega the linear body feels K q_f - omega^2 G_ff q_f: it is stable as long as this matrix is positive definite,
that is, as omega is below the lowest frequency of the body held by its frame.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.linalg import eigh

from toolkit.bodies.flexible import Flexible
from toolkit.responses.stress import flexible_body
from toolkit.scene import Scene
from toolkit.solution import Solution


def spinning_bodies(scene: Scene) -> list[str]:
    """Names of the flexible bodies whose frame can turn."""
    return [name for name, body in scene.bodies.items() if isinstance(body, Flexible) and body.has_frame]


def critical_speed(scene: Scene, body: str) -> float:
    """The speed of the body's frame, in rad/time, beyond which the linear body is unstable."""
    stiffness, mass = _scaled(scene, body)
    last = len(mass) - 1  # the largest eigenvalue of K^-1 G is exact, where the smallest of G^-1 K would drown in round-off
    return float(1 / np.sqrt(eigh(mass, stiffness, eigvals_only=True, subset_by_index=[last, last])[0]))


def too_fast_at_start(scene: Scene) -> Iterator[tuple[str, float]]:
    """Bodies that the scene starts beyond their critical speed, and how fast."""
    for body in spinning_bodies(scene):
        speed = abs(float(np.real(flexible_body(scene, body).velocity[2])))
        if not _stable(scene, body, speed):
            yield body, speed


def too_fast_in_motion(solution: Solution) -> Iterator[tuple[str, float]]:
    """Bodies that exceed their critical speed at any time, and the largest speed."""
    scene = solution.system.scene
    for body in spinning_bodies(scene):
        speed = float(np.abs(np.real(solution.v[:, solution.coordinates(body).start + 2])).max())
        if not _stable(scene, body, speed):
            yield body, speed


def _stable(scene: Scene, body: str, speed: float) -> bool:
    """Whether K - speed^2 G_ff is positive definite; far cheaper than the critical speed itself."""
    if speed == 0:
        return True
    stiffness, mass = _scaled(scene, body)
    try:
        np.linalg.cholesky(stiffness - speed**2 * mass)
    except np.linalg.LinAlgError:
        return False
    return True


def _scaled(scene: Scene, body: str) -> tuple[np.ndarray, np.ndarray]:
    """K, scaled to a unit diagonal, and G_ff in the same scale, (n_f, n_f)."""
    inv = flexible_body(scene, body).invariants(scene)
    stiffness, mass = np.real(inv.stiffness), np.real(inv.inertia[1:, 1:])
    scale = 1 / np.sqrt(np.diag(stiffness))
    return scale[:, None] * stiffness * scale, scale[:, None] * mass * scale
