"""Forces that loads and joints put on a flexible body at its interface points, whatever its basis knows of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from toolkit.compilation.numbering import grips_of
from toolkit.compilation.quantities import named_loads
from toolkit.description.design import BodyPoint
from toolkit.responses.balance import law_of_load
from toolkit.responses.least_squares_forces import wrenches_of_joints
from toolkit.responses.marker_formula import MarkerMotion
from toolkit.system.flexible_bodies import flexible_body
from toolkit.system.solution import Solution


def forces_at_points(solution: Solution, body: str, instants: np.ndarray) -> dict[str, np.ndarray]:
    """Interface point -> force (n_t, d) on the body at some instants, in the axes of its reduced model."""
    d = solution.system.scene.dimension
    return {name: wrench[:, :d] for name, wrench in wrenches_at_points(solution, body, instants).items()}


def wrenches_at_points(solution: Solution, body: str, instants: np.ndarray) -> dict[str, np.ndarray]:
    """Interface point -> force and moment about it on the body at some instants, in the axes of its reduced model; (n_t, 3 or 6)."""
    scene, where = solution.system.scene, solution.coordinates(body)
    written: Any = flexible_body(scene, body)
    axes = written.poses(np.real(solution.q[instants][:, where]))[1]
    found: dict[str, np.ndarray] = {}
    for point, wrench in [*_of_loads(solution, body, instants), *_of_joints(solution, body, instants)]:
        place = scene.points[point]
        if isinstance(place, BodyPoint):
            found[place.interface] = found.get(place.interface, 0.0) + _turned_back(axes, wrench)
    return found


def _turned_back(axes: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """Force and moment (n_t, 3 or 6) in axes (n_t, d, d); the moment of the plane is what it is."""
    vectors = [wrench[:, :2]] if axes.shape[1] == 2 else [wrench[:, :3], wrench[:, 3:]]
    turned = [np.einsum("tij,ti->tj", axes, each) for each in vectors]
    return np.concatenate([*turned, wrench[:, 2:]] if len(turned) == 1 else turned, axis=1)


def _of_loads(solution: Solution, body: str, instants: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Point and force with moment (n_t, 3 or 6) in space of every load that grips the body."""
    system = solution.system
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
            forces.append([_wrench(a.y, force[: len(a.y)]), _wrench(b.y, force[len(a.y) : 2 * len(a.y)])])
        for side, point in points:
            yield point, np.array(forces)[:, side]


def _wrench(pose: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Force and moment of what does work along a pose, 3 numbers in the plane, a position and three axes in space."""
    if len(pose) == 3:
        return np.real(force)
    moment = np.cross(pose[3:].reshape(3, 3), force[3:].reshape(3, 3)).sum(axis=0)
    return np.real(np.concatenate([force[:3], moment]))


def _numbers(solution: Solution, load: int) -> tuple[int, int]:
    """Where the curve and the own state of a load are; negative without one."""
    loads = solution.system.plan.loads
    return loads.curve[load], loads.state[load]


def _of_joints(solution: Solution, body: str, instants: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Point and force with moment (n_t, 3 or 6) in space of every joint that holds the body."""
    holding = [
        (j, side, point)
        for j, joint in enumerate(solution.system.scene.joints.values())
        for side, (gripped, point) in enumerate(joint.grips)
        if gripped == body
    ]
    if holding:
        joints = wrenches_of_joints(solution)
        found = np.array([joints.at(int(n)) for n in instants])
        for j, side, point in holding:
            yield point, found[:, j, side]
