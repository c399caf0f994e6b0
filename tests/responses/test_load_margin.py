"""The load margin: against the closed form of a shallow truss, and its gradient against differences of whole continuations."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.scenes import WING
from tests.scene_file.test_schemas import complaints
from toolkit.analyses.sensitivity.direct import numerical
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.components.bodies.rigid import Rigid, SpatialRigid
from toolkit.components.curves.polynomial import Constant
from toolkit.components.joints.driver import AngleDriver
from toolkit.components.joints.prismatic import Prismatic
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.point_force import PointForce, SpatialPointForce
from toolkit.components.loads.springs import SpatialSpringDamper, SpringDamper
from toolkit.description.design import Point
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import BifurcationError, ConvergenceError
from toolkit.responses.least_frequency import LoadMargin
from toolkit.scene.scene import Scene

SNAPPING = WING.parents[1] / "snap_through" / "scene.toml"
HALF, RISE, STIFFNESS, FORCE = 1.0, 0.4, 700.0, 6.0
NUMBERS = ("loads.left.stiffness", "loads.right.stiffness")


FIRST_LIMIT = [({"loads.drive.torque": 3000.0}, 0.9163847 * 4200 / 3000), ({"solver.continuation": "arc-length"}, 0.9163847)]
"""Changes of the wing that snaps, and the load factor at which `test_snap_through` knows it to."""


def truss(dimension: int, up_to: float = 10.0, rise: float = RISE, force: float = FORCE) -> Scene:
    """A block on two springs in a flat angle, guided downwards, and a force on it."""
    ends = {"L": (-HALF, 0.0), "R": (HALF, 0.0), "T": (0.0, rise)}
    points = {name: Point(x=x, y=y, **({} if dimension == 2 else {"z": 0.0})) for name, (x, y) in ends.items()}
    spring, rest = {"stiffness": STIFFNESS}, ("block", "ground")
    if dimension == 2:
        return Scene(
            units="m-kg-s",
            points=points,
            bodies={"block": Rigid(mass=1.0, inertia=0.1, center="T")},
            joints={"guide": Slider(bodies=rest, point="T", axis=(0.0, 1.0), lock_rotation=True)},
            loads={
                "left": SpringDamper(bodies=rest, points=("T", "L"), **spring),
                "right": SpringDamper(bodies=rest, points=("T", "R"), **spring),
                "push": PointForce(body="block", point="T", force=(0.0, -force)),
            },
            responses={"margin": LoadMargin(up_to=up_to)},
        )
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=points,
        bodies={"block": SpatialRigid(mass=1.0, inertia=(0.1, 0.1, 0.1), center="T")},
        joints={"guide": Prismatic(bodies=rest, point="T", axis=(0.0, 1.0, 0.0))},
        loads={
            "left": SpatialSpringDamper(bodies=rest, points=("T", "L"), **spring),
            "right": SpatialSpringDamper(bodies=rest, points=("T", "R"), **spring),
            "push": SpatialPointForce(body="block", point="T", force=(0.0, -force, 0.0)),
        },
        responses={"margin": LoadMargin(up_to=up_to)},
    )


def largest_force(half: complex = HALF, rise: complex = RISE) -> complex:
    """F = 2 k (L - l) sqrt(l^2 - b^2) / l at its maximum, l^3 = L b^2, with the undeformed length L and half the span b."""
    undeformed = np.sqrt(half**2 + rise**2)
    length = (undeformed * half**2) ** (1 / 3)
    return 2 * STIFFNESS * (undeformed - length) * np.sqrt(length**2 - half**2) / length


@pytest.mark.parametrize("method", ["direct", "adjoint", "complex-step"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_shallow_truss_snaps_under_the_load_of_the_closed_form(dimension, method):
    force = "loads.push.force.y" if dimension == 2 else "loads.push.force.1"
    found = gradients_by(method, truss(dimension), [*NUMBERS, force, "points.T.y"], "static")
    margin, slopes = found.values["margin"], found.gradients["margin"]
    # the load of a limit point is exact to the square of the place where it is found; the rest is round-off
    assert margin == pytest.approx(largest_force() / FORCE, rel=1e-10)
    assert sum(slopes[name] for name in NUMBERS) == pytest.approx(margin / STIFFNESS, rel=1e-8)
    assert slopes[force] == pytest.approx(margin / FORCE, rel=1e-8)  # the force is negative
    by_rise = np.imag(largest_force(rise=RISE + 1e-30j)) / 1e-30 / FORCE
    assert slopes["points.T.y"] == pytest.approx(by_rise, rel=1e-8)


@pytest.mark.parametrize(("changes", "expected"), FIRST_LIMIT)
def test_gradients_of_the_wing_are_differences_of_continuations(changes, expected):
    """Before its limit point, and followed past it."""
    scene = read_scene(SNAPPING, changes).model_copy(update={"responses": {"margin": LoadMargin()}})
    names = list(scene.design)
    exact = gradients_by("direct", scene, names, "static")
    assert exact.values["margin"] == pytest.approx(expected, rel=1e-6)
    wide, narrow = (numerical(scene, names, "static", "central-difference", relative_step=h) for h in (2e-3, 1e-3))
    for name in names:
        far, near = (found.gradients["margin"][name] for found in (wide, narrow))
        # the error of fourth order of the extrapolation, and round-off of a load factor, 1e-10, over the step
        assert exact.gradients["margin"][name] == pytest.approx(near + (near - far) / 3, rel=2e-6), name


def test_a_margin_that_is_beyond_what_is_looked_for_is_refused():
    with pytest.raises(ConvergenceError, match=r"no limit point up to .* times the load.*Raise `up_to`"):
        gradients_by("direct", truss(2, up_to=1.5), list(NUMBERS), "static")


def test_a_motion_leaves_the_margin_out():
    scene = truss(2)
    short = scene.solver.model_copy(update={"end_time": 0.01, "step": 0.005})
    assert gradients_by("direct", scene.model_copy(update={"solver": short}), list(NUMBERS), "transient").values == {}


def test_a_bifurcation_is_not_taken_for_a_limit_point():
    """Steep, and free to move aside, the block leaves the line of symmetry before the load is largest."""
    scene = truss(2, rise=3.0, force=500.0)
    upright = {"upright": AngleDriver(bodies=("block", "ground"), point="T", curve=Constant(value=0.0))}
    with pytest.raises(BifurcationError, match="bifurcation"):
        gradients_by("direct", scene.model_copy(update={"joints": upright}), list(NUMBERS), "static")


def test_it_meets_the_schema():
    assert complaints({"units": "m-kg-s", "bodies": {}, "responses": {"m": {"type": "load-margin", "up_to": 3.0}}}, "scene") == []
