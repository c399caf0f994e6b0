"""Every component in space against the complex step of its own residual, in states that are neither small nor consistent."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.models.any_scene import (  # noqa: F401  (they run on the scenes of this module)
    close,
    test_compiled_formulas_equal_the_plain_ones,
    test_constraint_forces_do_no_work_in_allowed_motions,
    test_constraint_levels_are_time_derivatives_of_one_another,
    test_design_derivatives_are_the_complex_step_of_the_residual,
    test_state_derivatives_are_the_complex_step_of_the_residual,
)
from tests.models.spatial_cases import AXIS, CASES, SpatialCase, write_models
from toolkit.analyses.transient import simulate
from toolkit.api.check import check_joint, check_load, check_load_formula, check_scene
from toolkit.components.bodies.rigid import SpatialRigid
from toolkit.components.joints.joint import AxisJoint, SpatialPointJoint
from toolkit.components.joints.rows import Form, Row
from toolkit.components.loads.load import Load, SpatialLoad
from toolkit.components.loads.springs import SpatialSpringDamper
from toolkit.components.markers.component import Skeleton
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConformanceError, InputError
from toolkit.foundation.kernel import kernel
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene


@pytest.fixture(scope="session")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("models")
    write_models(path)
    return path


@pytest.fixture(params=CASES, ids=lambda case: case.name)
def scene(request, directory) -> Scene:
    return request.param.scene(directory)


@pytest.mark.parametrize("case", [c for c in CASES if c.kind and issubclass(c.kind, Load)], ids=lambda case: case.name)
def test_derivatives_of_every_formula_are_the_complex_step_of_the_formula(case, directory):
    scene = case.scene(directory)
    check_load_formula(scene.loads["component"], scene, np.random.default_rng(1))


def case_of(kind: type, directory) -> Scene:
    return next(case for case in CASES if case.kind is kind).scene(directory)


class Slope(AxisJoint):
    """A user's own joint: the point of body a stays on the axis and its normal plane keeps an offset that grows with the point's x."""

    kind = "test-slope"

    pitch: float

    def constraint(self, scene: Skeleton | None) -> tuple[Row, ...]:
        """Offset along the axis - pitch * x of the point in space."""
        a, b = self.poses
        d = a.r - b.r
        return (Row("axis", "length", d @ b.e(3) - self.pitch * d[0]),)


def test_a_users_own_joint_in_space_plugs_in(directory):
    case = SpatialCase("slope", Slope, {"axis": AXIS, "pitch": 0.3}, ("block", "wheel"), ("C", "B"), "B")
    check_joint(case.scene(directory).joints["component"], case.scene(directory))


def test_a_bead_on_a_users_slope_keeps_its_energy():
    """z = pitch x."""
    scene = Scene(
        units="m-kg-s",
        dimension=3,
        points={"P": Point(x=0.0, y=0.0, z=0.0)},
        bodies={"bead": SpatialRigid(mass=2.0, inertia=(1.0, 1.0, 1.0), center="P", velocity=(1.0, 0.0, 0.3))},
        joints={"slope": Slope(bodies=("bead", "ground"), point="P", axis=(0.0, 0.0, 1.0), pitch=0.3)},
    )
    run = simulate(compile_scene(scene), RunOptions(end_time=1.0, step=1e-2, rho_inf=1.0))
    np.testing.assert_allclose(run.q[:, 2], 0.3 * run.q[:, 0], atol=1e-12)  # a plane: linear, so that only round-off is left
    np.testing.assert_allclose(run.v[:, 0], 1.0, atol=1e-12)


def wrong_slope(constraint: Any, directory) -> tuple[Any, Scene]:
    """A joint with other rows, and a scene for it."""
    kind = type("Wrong", (Slope,), {"kind": "test-wrong-slope", "constraint": constraint, "__module__": __name__})
    case = SpatialCase("slope", Slope, {"axis": AXIS, "pitch": 0.3}, ("block", "wheel"), ("C", "B"), "B")
    return kind(bodies=("block", "wheel"), point="B", axis=AXIS, pitch=0.3), case.scene(directory)


def test_rows_that_name_what_no_pose_has_are_refused_by_name(directory):
    joint, scene = wrong_slope(lambda _self, _scene: (Row("wild", "length", Form(pairs=((0, 9, 1.0),))),), directory)
    with pytest.raises(InputError, match=r"row 'wild' of a 'test-wrong-slope' joint names vector 9; .* 0 to 7"):
        check_joint(joint, scene)


def test_rows_that_change_with_the_scene_are_refused_by_name(directory):
    def constraint(_self, scene):
        return (
            (Row("axis", "length", Form(linear=((0, 1.0),))),)
            if scene is None
            else (Row("axis", "length", Form(linear=((1, 1.0),))),)
        )

    with pytest.raises(InputError, match="'test-wrong-slope' joint has other rows with a scene than without"):
        check_joint(*wrong_slope(constraint, directory))


@kernel
def forgetful_wind(z, w, force, force_z, force_w):
    """f_a = -p (v . v) e_1 would need 2 v; this one states half of it, and forgets the axis."""
    for i in range(3):
        square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
        force[i] = -z[24] * square * z[3 + i]
        force_z[i, 24] = -square * z[3 + i]
        force_z[i, 3 + i] = -z[24] * square
        for j in range(3):
            force_w[i, j] = -z[24] * w[j] * z[3 + i]


class ForgetfulWind(SpatialSpringDamper):
    """A load with a wrong derivative by the rate."""

    kind = "test-forgetful-wind"
    formula = forgetful_wind

    @property
    def feels_axes(self) -> bool:
        """An axis."""
        return True


class BlindWind(ForgetfulWind):
    """One that hides its axes too."""

    kind = "test-blind-wind"

    @property
    def feels_axes(self) -> bool:
        """Wrong."""
        return False


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (ForgetfulWind, r"force_w is wrong at \(force in . on position of a, rate of . of position of a\)"),
        (BlindWind, "its formula uses axes of the markers, but `feels_axes` is False"),
    ],
)
def test_a_wrong_load_in_space_is_caught_and_named(kind, message, directory):
    scene = SpatialCase("wind", kind, {"stiffness": 0.6}, ("rod", "ground"), ("A", "O"), "A").scene(directory)
    with pytest.raises(ConformanceError, match=message):
        check_load(scene.loads["component"], scene)


def test_a_load_in_space_passes_the_public_check(directory):
    scene = case_of(SpatialSpringDamper, directory)
    check_load(scene.loads["component"], scene, seed=1)
    check_scene(scene)


def test_a_load_without_formula_cannot_be_created():
    with pytest.raises(TypeError, match=r"Lawless has no `formula`.*must not pass for zero"):
        type("Lawless", (SpatialLoad,), {"kind": "test-lawless", "__module__": __name__})


def test_a_joint_without_rows_cannot_be_created():
    with pytest.raises(TypeError, match="Rowless has no `constraint`"):
        type("Rowless", (SpatialPointJoint,), {"kind": "test-rowless", "__module__": __name__})
