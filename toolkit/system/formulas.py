"""Formulas of a scene's joints and loads, ready for the compiled loop or as plain Python."""

from __future__ import annotations

from toolkit.compilation.arrays.component_arrays import families
from toolkit.compilation.arrays.joint_arrays import laws_of
from toolkit.compilation.quantities import loads_of
from toolkit.foundation.kernel import plain, slots
from toolkit.joints.kernels.laws import SIGNATURE as LAW_SIGNATURE
from toolkit.joints.kernels.laws import angle_law
from toolkit.loads.kernels.load_kernel import SIGNATURE as LOAD_SIGNATURE
from toolkit.loads.torque import torque
from toolkit.scene.resolution import ResolvedScene


def _formulas(scene: ResolvedScene) -> tuple[list, list]:
    """Open formulas of the scene's joints, each once, and formulas of its loads; there is always one of each."""
    return laws_of(list(scene.joints.values())) or [angle_law], families(loads_of(scene)) or [torque]


def formulas_of(scene: ResolvedScene) -> tuple[tuple, tuple]:
    """Formulas of the scene's joints and loads, ready for the compiled loop."""
    joints, loads = _formulas(scene)
    return slots(joints, LAW_SIGNATURE), slots(loads, LOAD_SIGNATURE)


def plain_formulas_of(scene: ResolvedScene) -> tuple[tuple, tuple]:
    """Formulas of the scene's joints and loads as plain Python."""
    joints, loads = _formulas(scene)
    return tuple(map(plain, joints)), tuple(map(plain, loads))
