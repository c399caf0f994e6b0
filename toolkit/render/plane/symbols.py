"""Drawing symbols of joints and supports: which stands where, and the lines it consists of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.joints.joint import Joint
from toolkit.joints.revolute import Revolute
from toolkit.joints.rigid_joint import RigidJoint, Tie
from toolkit.joints.slider import Slider
from toolkit.kinematics.planar import unit_vector
from toolkit.render.moment import POINT
from toolkit.render.plane.configuration import Configuration
from toolkit.render.plane.skin_shape import drawn_model

_ALONG_X = np.array([1.0, 0.0])


class Symbol(NamedTuple):
    """A symbol at a point (2,), its own x axis along a direction (2,)."""

    kind: str
    point: np.ndarray
    direction: np.ndarray = _ALONG_X

    def lines(self, size: float) -> list[np.ndarray]:
        """Polylines (n, 2) that draw the symbol around its point."""
        c, s = self.direction
        return [size * corners @ np.array([[c, s], [-s, c]]) for corners in _LINES[self.kind]]


def symbols(configuration: Configuration) -> list[Symbol]:
    """Symbols of pins, sliders, supports, clamps and masses of a scene.

    What turns freely has a pin, what is fixed to the ground a hatched side.

    A named point that none of these stands at is a dot.
    """
    found = [symbol for joint in configuration.joints() for symbol in _joint_symbols(configuration, joint)]
    for link in configuration.links():
        for (body, _), end in zip(link.grips, configuration.ends(link), strict=True):
            found += [Symbol("pin", end)] + [Symbol("support", end)] * (body == "ground")
    found += [Symbol("clamp", point) for points in clamps(configuration).values() for point in points]
    return found + [Symbol("point", point) for point in configuration.bare_points([each.point for each in found])]


def clamps(configuration: Configuration) -> dict[str, np.ndarray]:
    """Clamped nodes (n, 2) of every grounded flexible body, n > 0.

    They are those that no elastic coordinate moves, or that tie cut bodies to the ground.
    """
    ties = [each for each in configuration.scene.joints.values() if isinstance(each, Tie) and "ground" in each.bodies]
    found = {}
    for body in configuration.flexible():
        mesh = drawn_model(configuration, body).mesh
        if mesh is not None and not configuration.scene.body(body).has_frame:
            still = ~np.any(mesh.recovery[:, 1:].reshape(len(mesh.nodes), -1), axis=1)
            found[body] = configuration.place(body, mesh.nodes[still])
        if isinstance(configuration.scene.body(body), CutBody):
            held = [configuration.ends(tie)[0] for tie in ties if body in tie.bodies]
            found[body] = np.reshape(held, (-1, 2))
    return {body: points for body, points in found.items() if len(points)}


def _joint_symbols(configuration: Configuration, joint: Joint) -> list[Symbol]:
    """Symbols of one joint.

    A slider is drawn where its point is now, along the axis of the body that carries it; any new kind of joint is a pin.
    """
    point, grounded = configuration.ends(joint)[0], "ground" in joint.bodies
    if isinstance(joint, RigidJoint):
        alone = any(_is_a_point(configuration, body) for body in joint.bodies if body != "ground")
        return [Symbol("clamp", point)] if grounded else [Symbol("mass", point)] * alone
    if isinstance(joint, Slider):
        axis = configuration.turned(*joint.grips[1], unit_vector(np.real(joint.axis)))
        rails = Symbol("grounded slider" if grounded else "slider", point, axis)
        return [rails] if joint.lock_rotation else [rails, Symbol("pin", point)]
    return [Symbol("pin", point)] + [Symbol("support", point)] * (grounded and isinstance(joint, Revolute))


def _is_a_point(configuration: Configuration, body: str) -> bool:
    """Whether a body is drawn as nothing but a point: a mass that is fixed to another body at its centre."""
    lines, size = configuration.segments(body), configuration.scene.size
    return bool(lines) and all(np.ptp(line, axis=0).max() < POINT * size for line in lines)


def _hatched(half: float, y: float, depth: float) -> list[np.ndarray]:
    """Line from (-half, y) to (half, y) with strokes on the solid side: below for a negative depth."""
    strokes = [np.array([[x, y], [x - 0.35, y + depth]]) for x in np.linspace(0.4 - half, half, 5)]
    return [np.array([[-half, y], [half, y]]), *strokes]


def _box(x: float, y: float) -> np.ndarray:
    return np.array([[-x, -y], [x, -y], [x, y], [-x, y], [-x, -y]])


_CIRCLE = np.linspace(0, 2 * np.pi, 17)
_LINES = {
    "pin": [0.5 * np.column_stack([np.cos(_CIRCLE), np.sin(_CIRCLE)])],
    "mass": [_box(0.6, 0.6)],
    "point": [0.22 * np.column_stack([np.cos(_CIRCLE), np.sin(_CIRCLE)])],
    "support": [np.array([[0.0, 0.0], [-0.6, -1.0], [0.6, -1.0], [0.0, 0.0]]), *_hatched(1.0, -1.0, -0.45)],
    "clamp": [_box(1.0, 1.0), *(np.array(ends) for ends in (((-1, 0), (0, 1)), ((-1, -1), (1, 1)), ((0, -1), (1, 0))))],
    "slider": [_box(0.9, 0.8), np.array([[-1.7, -1.1], [1.7, -1.1]]), np.array([[-1.7, 1.1], [1.7, 1.1]])],
    "grounded slider": [_box(0.9, 0.8), *_hatched(1.7, -1.1, -0.45), *_hatched(1.7, 1.1, 0.45)],
}
