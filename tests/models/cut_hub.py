"""A beam with three floating frames from which joints of every kind carry a block each, in the plane or in space."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tests.models import cases, spatial_cases
from tests.models.every_number import LEAD, SOLVER
from tests.models.spatial_chains import save_chain
from tests.models.spatial_every_number import TENSOR
from toolkit.components.bodies.flexible import Flexible, SpatialFlexible
from toolkit.components.bodies.rigid import Rigid, SpatialRigid
from toolkit.components.joints.joint import Joint
from toolkit.components.loads.bushing import Bushing, SpatialBushing
from toolkit.components.loads.gravity import Gravity, SpatialGravity
from toolkit.description.design import BodyPoint, Point
from toolkit.responses.energy import KineticEnergy, StrainEnergy
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.responses.stress import KSStress
from toolkit.scene.scene import Scene

NODES = np.array([[0.0, 0.0, 0.0], [0.6, 0.1, 0.1], [1.0, 0.5, 0.0], [1.1, 1.2, -0.2], [1.0, 1.9, 0.1]])
CUTS = (1, 3)
"""The point `middle` is the node between them, so that it lies inside of the second part."""
YOUNG = 3e9
"""With it the beam bends by a twentieth of its length."""


def joints_of(dimension: int) -> list[tuple[str, type[Joint], dict[str, Any]]]:
    """Name, kind and numbers of every kind of joint; drivers begin slowly, and lengths where the points are."""
    kinds = (spatial_cases if dimension == 3 else cases).KINDS
    found = [(name, kind, numbers) for name, kind, numbers in kinds if issubclass(kind, Joint)]
    gentle = {
        "angle driver": {"curve": LEAD},
        "position driver": {"curve": LEAD},
        "distance of given length": {"length": 1.9 if dimension == 2 else 1.3},
    }
    return [(name.replace(",", ""), kind, numbers | gentle.get(name, {})) for name, kind, numbers in found]


def hub(folder: Path, dimension: int, joints: Sequence[int], frames: object = CUTS, young: float = YOUNG, **solver) -> Scene:
    """The scene with the joints of these numbers in `joints_of`; the beam and all blocks lie on bushings, so that it can rest too."""
    nodes, space = NODES[:, :dimension], dimension == 3
    save_chain(folder, nodes, 'kind = "rectangle", thickness = 0.03, width = 0.04', young, damping=0.01)
    turned = (
        {"orientation": (0.3, -0.5, 0.7), "angular_velocity": (0.3, 0.1, -0.2)}
        if space
        else {"angle": 0.4, "angular_velocity": 0.3}
    )
    flexible, rigid, gravity = (SpatialFlexible, SpatialRigid, SpatialGravity) if space else (Flexible, Rigid, Gravity)
    beam = flexible(model="beam.h5", frames=frames, position=(0.2, -0.3, 0.1)[:dimension], **turned)
    parts: dict[str, dict[str, Any]] = {
        "points": {name: BodyPoint(body="beam", interface=name) for name in ("root", "middle", "tip")},
        "bodies": {"beam": beam},
        "joints": {},
        "loads": {"weight": gravity(acceleration=(0.2, -0.5, 0.3)[:dimension]), "bed": bed("beam", "root", dimension, 4.0)},
        "responses": {
            **{axis: Displacement(body="beam", point="tip", component=axis) for axis in "xyz"[:dimension]},
            "kinetic": KineticEnergy(),
            "strain": StrainEnergy(),
            "stress": KSStress(body="beam", aggregation=20.0, reference_stress=1e6),
        },
    }
    every = joints_of(dimension)
    for k in joints:
        name, kind, numbers = every[k]
        block, foot, grip = f"block of {name}", f"foot of {name}", ("middle", "tip")[k % 2]
        for point, radius, ahead in ((block, 1.3, 0.0), (foot, 1.4, 0.1)):
            angle = 2.4 * k + ahead
            place = (radius * np.cos(angle), radius * np.sin(angle) + 0.4, 0.3 * np.cos(3 * angle))
            parts["points"][point] = Point(**dict(zip("xyz", map(float, place[:dimension]), strict=False)))
        parts["bodies"][block] = rigid(mass=1.4, inertia=TENSOR if space else 0.6, center=block)
        parts["loads"][f"bed of {name}"] = bed(block, foot, dimension, 1.0)
        bodies, points = (("beam", block), (grip, block)) if k % 3 == 0 else ((block, "beam"), (block, grip))
        given = {"bodies": bodies, "points": points, "point": grip}
        parts["joints"][name] = kind(**{key: value for key, value in given.items() if key in kind.model_fields}, **numbers)
        parts["responses"][f"force of {name}"] = JointForce(joint=name, component="x")
        parts["responses"][f"torque of {name}"] = JointForce(joint=name, component="torque-y" if space else "torque")
        parts["responses"][f"way of {name}"] = Displacement(body=block, point=block, component="y")
    options = SOLVER.model_copy(update={"end_time": 0.01, "step": 0.01, **solver})
    return Scene(units="m-kg-s", dimension=dimension, directory=folder, solver=options, **parts)


def bed(body: str, point: str, dimension: int, factor: float) -> Any:
    """A bushing to the ground, other in every direction."""
    stiffness, turning = factor * np.array([21.0, 17.0, 13.0]), factor * np.array([9.0, 7.0, 11.0])
    kind, own = (SpatialBushing, tuple(turning.tolist())) if dimension == 3 else (Bushing, float(turning[0]))
    damping = tuple((0.05 * turning).tolist()) if dimension == 3 else 0.05 * own
    return kind(
        bodies=(body, "ground"),
        point=point,
        stiffness=tuple(stiffness[:dimension].tolist()),
        damping=tuple((0.05 * stiffness[:dimension]).tolist()),
        rotational_stiffness=own,
        rotational_damping=damping,
    )
