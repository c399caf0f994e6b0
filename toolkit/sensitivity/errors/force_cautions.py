"""What joint forces that alternate mean for the responses of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from toolkit.foundation.verdict import Caution
from toolkit.responses.forces.joint_force import JointForce
from toolkit.system.solution import Solution
from toolkit.validity.motion.noisy_forces import NOISY, noise_at, noise_of_joints, noisy_forces


def force_cautions(solution: Solution, noise: Mapping[str, Any]) -> Iterator[Caution]:
    """A doubt where a response is such a force, at the time that it asks for; otherwise a remark. The noise is that of `force_noise`."""
    scene = solution.system.scene
    if not noise or noise["size"] <= NOISY:
        return
    joints = noise_of_joints(solution)
    asked = {name: each for name, each in scene.responses.items() if isinstance(each, JointForce)}
    noisy = [name for name, each in asked.items() if noise_at(joints[each.joint], each.step(solution)) > NOISY]
    yield from noisy_forces(solution.options or scene.solver, noise, noisy)
