"""Design variables that would open the curve of a cam whose end its follower has passed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.near_ties import spread
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.joints.cam import OnCam
from toolkit.joints.kernels.profile import SEAM
from toolkit.joints.profile import CLOSE, TURN
from toolkit.joints.rows import Form
from toolkit.scene.scene import Scene
from toolkit.system.marker_states import poses_at
from toolkit.system.solution import Solution

STEP = 1e-30
LOOKED_AT = 500
"""Number of instants that are examined."""


@check("cam-opened", STATES)
def opened_profiles(solution: Solution) -> Iterator[Caution]:
    """A variable of the design moves the end of a cam's closed curve away from its beginning, and the cam has passed both.

    Limit: any.
    Fix: one variable for the numbers of both ends.

    The follower would jump there, and its derivative by that variable misses it.
    """
    system = solution.system
    cams = {name: joint for name, joint in system.scene.joints.items() if isinstance(joint, OnCam)}
    for name in cams:
        opening = [each.name for each in system.design if _opens(system.scene, name, list(each.paths), list(each.factors))]
        if opening and _passes(solution, name):
            yield opened_profiles.caution(
                f"{', '.join(opening)} would open the curve of joints.{name}, whose end is its beginning after a turn, and the cam has "
                f"passed it. The follower would jump there, which no derivative knows. {opened_profiles.fix}",
            )


def _opens(scene: Scene, name: str, paths: list[str], factors: list[float]) -> bool:
    """Whether a variable moves value or slope at the end of a curve apart from those at its beginning."""
    moved = scene
    for path, factor in zip(paths, factors, strict=True):
        if path.startswith(f"joints.{name}.curve."):
            moved = moved.with_number(path, moved.number(path) + 1j * STEP * factor)
    joint = moved.joints[name]
    assert isinstance(joint, OnCam)
    slopes = np.imag(joint.curve.evaluate(np.linspace(0, TURN, 721)))[:, :2]
    return bool(np.any(np.abs(slopes[-1] - slopes[0]) > CLOSE * np.abs(slopes).max(axis=0)))


def _passes(solution: Solution, name: str) -> bool:
    """Whether the angle of the cam leaves the turn that it begins in."""
    system = solution.system
    joint = system.scene.joints[name]
    sine, cosine = joint.constraint(system.scene)[0].forms[-2], joint.constraint(system.scene)[0].forms[-3]
    markers = [system.numbering.marker(grip if joint.axes is None else (*grip, f"joints.{name}")) for grip in joint.grips]
    states = np.atleast_2d(np.real(solution.q))
    poses = [_vectors(pose) for pose in poses_at(system, states[spread(len(states) - 1, LOOKED_AT)])[:, markers]]
    angles = np.unwrap([np.arctan2(_value(sine, vectors), _value(cosine, vectors)) for vectors in poses])
    return bool(angles.min() < -SEAM or angles.max() >= TURN - SEAM)


def _vectors(pose: np.ndarray) -> np.ndarray:
    """Position and axes of both markers, and in the plane the difference of both positions behind them, see `toolkit.joints.poses`."""
    if pose.shape[1] > 3:
        return pose.reshape(8, 3)
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    own = np.stack([pose[:, :2], np.column_stack([c, s]), np.column_stack([-s, c])], axis=1).reshape(6, 2)
    return np.vstack([own, own[0] - own[3]])


def _value(form: Form, vectors: np.ndarray) -> float:
    """Value of a form of products of vectors."""
    return float(sum(np.real(value) * (vectors[i] @ vectors[k]) for i, k, value in form.pairs))
