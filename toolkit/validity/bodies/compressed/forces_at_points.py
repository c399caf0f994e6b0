"""Forces that loads and joints put on a flexible body at its interface points, whatever its basis knows of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from toolkit.compilation.numbering import grips_of
from toolkit.compilation.quantities import named_loads
from toolkit.description.point import BodyPoint
from toolkit.responses.balance.power_of_load import law_of_load
from toolkit.responses.forces.joint_force import JointForce
from toolkit.responses.kinematics.marker_motion import MarkerMotion
from toolkit.system.flexible_bodies import flexible_body
from toolkit.system.solution import Solution


def forces_at_points(solution: Solution, body: str, instants: np.ndarray) -> dict[str, np.ndarray]:
    """Interface point -> force (n_t, d) on the body at some instants, in the axes of its reduced model."""
    scene, where = solution.system.scene, solution.coordinates(body)
    written: Any = flexible_body(scene, body)
    axes = written.poses(np.real(solution.q[instants][:, where]))[1]
    found: dict[str, np.ndarray] = {}
    for point, force in [*_of_loads(solution, body, instants), *_of_joints(solution, body, instants)]:
        place = scene.points[point]
        if isinstance(place, BodyPoint):
            found[place.interface] = found.get(place.interface, 0.0) + np.einsum("tij,ti->tj", axes, force)
    return found


def _of_loads(solution: Solution, body: str, instants: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Point and force (n_t, d) in space of every load that grips the body."""
    system, d = solution.system, solution.system.scene.dimension
    curves = system.curves(solution.times)[0]
    for k, (name, load) in enumerate(named_loads(system.scene).items()):
        points = [(side, point) for side, (gripped, point) in enumerate(load.grips) if gripped == body]
        if not points:
            continue
        motion, curve, state = MarkerMotion.of(system, grips_of(f"loads.{name}", load)), *_numbers(solution, k)
        forces = []
        for n in instants:
            a, b = motion.at(solution, n)
            own = solution.q[n, state] if state >= 0 else 0.0
            force = np.real(law_of_load(system, load, k, (a, b), own, curves[n, curve, 0] if curve >= 0 else 1.0)[0])
            forces.append([force[:d], force[len(a.y) : len(a.y) + d]])
        for side, point in points:
            yield point, np.array(forces)[:, side]


def _numbers(solution: Solution, load: int) -> tuple[int, int]:
    """Where the curve and the own state of a load are; negative without one."""
    loads = solution.system.plan.loads
    return loads.curve[load], loads.state[load]


def _of_joints(solution: Solution, body: str, instants: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Point and force (n_t, d) in space of every joint that holds the body."""
    d = solution.system.scene.dimension
    for name, joint in solution.system.scene.joints.items():
        for sign, (gripped, point) in zip((1.0, -1.0), joint.grips, strict=True):
            if gripped == body:
                of_joint = JointForce(joint=name, component="x")
                yield point, sign * np.real([of_joint.force(solution, n)[0][:d] for n in instants])
