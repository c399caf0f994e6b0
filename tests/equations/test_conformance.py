"""Every component against the complex step of its own residual, in states that are neither small nor consistent."""

from __future__ import annotations

import runpy
from dataclasses import replace

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
from tests.models.cases import CASES, Case, write_models
from tests.models.four_bars import four_bars
from tests.models.scenes import WING
from toolkit.analyses.transient import simulate
from toolkit.api.check import check_joint, check_laws, check_load, check_load_formula, check_scene
from toolkit.api.comparison import STEP, check_state_derivatives, inputs, plain_terms, random_state
from toolkit.components.bodies.body import Body
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.joints.driver import PositionDriver
from toolkit.components.joints.joint import Joint, PlanarJoint, PointJoint
from toolkit.components.joints.kernels.records import PINNED
from toolkit.components.joints.rows import Row
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.load import Load, PlanarLoad
from toolkit.components.loads.springs import SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.components.markers.component import Skeleton
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConformanceError, InputError
from toolkit.foundation.kernel import kernel
from toolkit.scene.kinds import kinds_of
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.joint_arrays import laws_of
from toolkit.system.system import System, compile_scene


@pytest.fixture(scope="session")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("models")
    write_models(path)
    return path


@pytest.fixture(params=CASES, ids=lambda case: case.name)
def scene(request, directory) -> Scene:
    return request.param.scene(directory)


@pytest.mark.parametrize("case", [case for case in CASES if case.kind], ids=lambda case: case.name)
def test_derivatives_of_every_formula_are_the_complex_step_of_the_formula(case, directory):
    scene, rng = case.scene(directory), np.random.default_rng(1)
    if "component" in scene.joints:
        check_laws(scene.joints["component"], scene, rng)
    else:
        check_load_formula(scene.loads["component"], scene, rng)


@pytest.mark.parametrize("kind", [Slider, SpringDamper])
def test_a_joint_and_a_load_pass_the_public_check(kind, directory):
    scene = next(case for case in CASES if case.kind is kind).scene(directory)
    if kind is Slider:
        check_joint(scene.joints["component"], scene, seed=1)
    else:
        check_load(scene.loads["component"], scene, seed=1)


@pytest.mark.parametrize("case", [case for case in CASES if case.kind is None], ids=lambda case: case.name)
def test_inertia_forces_are_those_of_lagrange(case, directory):
    """M a - F_v = d/dt (M v) - d/dq (v^T M v / 2), with M(q) from the coefficients of the accelerations."""
    system = compile_scene(case.scene(directory))
    (q, v, acc), n_q = random_state(system), system.n_q

    def mass(position: np.ndarray) -> np.ndarray:
        return system.matrix(plain_terms(system, inputs(system), position, 0 * v, 0 * acc, linearize=True).I_acc).toarray()

    rate = np.stack([mass(q + 1j * STEP * e).imag / STEP for e in np.eye(system.n)[:n_q]])  # (k, i, j): dM_ij / dq_k
    M, damping = mass(q), system.matrix(system.evaluate(inputs(system), q, 0 * v, acc).A_v) @ v
    lagrange = M @ acc + np.einsum("kij,k,j->i", rate, v, v) - np.einsum("kij,i,j->k", rate, v, v) / 2
    moving, resting = (system.evaluate(inputs(system), q, rates, acc) for rates in (v, 0 * v))
    close(moving.inertial + moving.applied - resting.applied - damping, lagrange, tolerance=1e-12)
    np.testing.assert_allclose(M, M.T, rtol=0, atol=1e-14)


@kernel
def parabola(h, w, g, g_h, g_hh, g_hww):
    """g = y - p x^2 of h = (x, y, p)."""
    x, p = h[0], h[2]
    g[0] = h[1] - p * x * x
    g_h[0], g_h[1], g_h[2] = -2 * p * x, 1, -x * x
    g_hh[0, 0] = -2 * p
    g_hh[0, 2] = g_hh[2, 0] = -2 * x
    g_hww[0], g_hww[2] = -4 * w[0] * w[2], -2 * w[0] * w[0]


class ParabolaGuide(PointJoint):
    """A user's own joint: the point of body a moves on a parabola fixed in space with its vertex at the point of body b."""

    kind = "test-parabola-guide"

    steepness: float

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        """One direction."""
        a, b = self.poses
        d = a.r - b.r
        return (Row("height", "length", (d[0], d[1], self.steepness), parabola),)


@pytest.mark.parametrize(("bodies", "point"), [(("strip", "rod"), "T"), (("rod", "ground"), "A")])
def test_a_users_own_joint_plugs_in(bodies, point, directory):
    scene = Case("parabola", ParabolaGuide, {"steepness": 0.6}, bodies, (point, point), point).scene(directory)
    check_scene(scene)
    check_joint(scene.joints["component"], scene)


def test_a_bead_on_a_users_parabola_keeps_its_energy():
    scene = Scene(
        units="m-kg-s",
        points={"P": Point(x=0.0, y=0.0)},
        bodies={"bead": Rigid(mass=2.0, inertia=1.0, center="P", velocity=(3.0, 0.0, 0.0))},
        joints={"wire": ParabolaGuide(bodies=("bead", "ground"), point="P", steepness=0.6)},
        loads={"gravity": Gravity(acceleration=(0.0, -9.81))},
    )
    run = simulate(compile_scene(scene), RunOptions(end_time=2.0, step=1e-3, rho_inf=1.0))
    energy = (run.v[:, :2] ** 2).sum(axis=1) / 2 + 9.81 * run.q[:, 1]
    assert np.abs(energy / energy[0] - 1).max() < 1e-4  # second order: (step / shortest time scale)^2 = (1e-3 / 0.1)^2
    np.testing.assert_allclose(run.q[:, 1], 0.6 * run.q[:, 0] ** 2, atol=1e-5)


MISTAKES = {
    "g_h": ("g_h[1] = -g_h[1]", r"g_h is wrong at \(height, h\[1\]\): it is -1, a complex step gives 1; "),
    "g_h by a number": ("g_h[2] = -g_h[2]", r"g_h is wrong at \(height, h\[2\]\)"),
    "g_hh": ("g_hh[0, 0] = -g_hh[0, 0]", r"g_hh is wrong at \(h\[0\], h\[0\]\): it is 1.2, .* gives -1.2"),
    "g_hww": ("g_hww[2] = -g_hww[2]", r"g_hww is wrong at \(height, h\[2\]\)"),
    "forgotten": ("g_h[1] = 0", r"g_h is wrong at \(height, h\[1\]\): it is 0, a complex step gives 1"),
}
"""A line that spoils the parabola, and what the check says about it."""


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_wrong_derivative_of_a_users_joint_is_caught_and_named(mistake, tmp_path, monkeypatch, directory):
    line, message = MISTAKES[mistake]
    own = tmp_path / "own_joint.py"
    own.write_text(
        "from toolkit.foundation.kernel import kernel\nfrom tests.equations.test_conformance import parabola\n\n\n@kernel\n"
        f"def spoiled(h, w, g, g_h, g_hh, g_hww):\n    parabola(h, w, g, g_h, g_hh, g_hww)\n    {line}\n"
    )
    spoiled = runpy.run_path(str(own))["spoiled"]

    def constraint(self, scene):
        (row,) = ParabolaGuide.constraint(self, scene)
        return (Row(row.name, row.quantity, row.form, spoiled),)

    kind = type("Spoiled", (ParabolaGuide,), {"kind": "test-spoiled", "constraint": constraint, "__module__": __name__})
    scene = Case("parabola", ParabolaGuide, {"steepness": 0.6}, ("rod", "ground"), ("A", "A"), "A").scene(directory)
    with pytest.raises(ConformanceError, match=f"row 'height' of 'test-spoiled': {message}"):
        check_joint(kind(bodies=("rod", "ground"), point="A", steepness=0.6), scene)


def test_a_joint_of_another_scene_is_refused(directory):
    scene = Case("parabola", ParabolaGuide, {"steepness": 0.6}, ("rod", "ground"), ("A", "A"), "A").scene(directory)
    with pytest.raises(ValueError, match="names body 'wheel', which does not exist"):
        check_joint(ParabolaGuide(bodies=("wheel", "ground"), point="A", steepness=0.6), scene)


@kernel
def forgetful_drag(z, w, force, force_z, force_w):
    """f_x = -p v_x |v_x| would need 2 |v_x|; this one states half of it."""
    force[0] = -z[6] * w[0] * w[0]
    force_z[0, 6] = -w[0] * w[0]
    force_w[0, 0] = -z[6] * w[0]


class ForgetfulDrag(Torque):
    """A load with a wrong derivative by the rate."""

    kind = "test-forgetful-drag"
    formula = forgetful_drag


def test_a_wrong_derivative_of_a_load_is_caught_and_named(directory):
    scene = Case("drag", ForgetfulDrag, {"torque": 0.6}, ("rod", "ground"), ("A", "A"), "A").scene(directory)
    with pytest.raises(ConformanceError, match=r"force_w is wrong at \(force in x on a, rate of x of a\)"):
        check_load(scene.loads["component"], scene)


@kernel
def stateful(z, w, force, force_z, force_w):
    """A torque of p times a state that nobody has announced."""
    force[2], force_z[2, 6], force_w[2, 6] = z[6] * w[6], w[6], z[6]


class Unannounced(Torque):
    """A load that uses a state without having one."""

    kind = "test-unannounced"
    formula = stateful


def test_a_load_that_uses_a_state_without_having_one_is_refused(directory):
    scene = Case("state", Unannounced, {"torque": 0.6}, ("rod", "ground"), ("A", "A"), "A").scene(directory)
    with pytest.raises(ConformanceError, match="that of a state of its own, but it has none: nobody would integrate it"):
        check_load(scene.loads["component"], scene)


def test_equations_that_miss_a_derivative_are_caught_with_the_names_of_their_unknowns(directory, monkeypatch):
    scene = next(case for case in CASES if case.kind is PositionDriver).scene(directory)
    original = System.dense
    monkeypatch.setattr(System, "dense", lambda system, values: original(system, np.where(values == values.max(), 0, values)))
    with pytest.raises(ConformanceError, match=r"d inertial / d .* is wrong at \(.* of body .*, .* of .*\): it is 0, a complex"):
        check_scene(scene)


@pytest.mark.parametrize(("base", "what"), [(PlanarJoint, "constraint"), (PointJoint, "constraint"), (PlanarLoad, "formula")])
def test_a_component_that_does_not_state_its_law_cannot_be_created(base, what):
    with pytest.raises(TypeError, match=rf"Forgetful has no `{what}`"):
        type("Forgetful", (base,), {"kind": "test-forgetful", "__module__": __name__})
    assert "test-forgetful" not in {**kinds_of(2)["joints"], **kinds_of(2)["loads"]}


@pytest.mark.parametrize(
    ("base", "right"),
    [(Joint, "PlanarJoint or SpatialJoint"), (Load, "PlanarLoad or SpatialLoad"), (Body, "PlanarBody or SpatialBody")],
    ids=["joint", "load", "body"],
)
def test_a_component_of_no_space_cannot_be_created(base, right):
    body = {"kind": "test-nowhere", "__module__": __name__} | ({"formula": forgetful_drag} if base is Load else {})
    with pytest.raises(TypeError, match=f"Nowhere belongs neither to the plane nor to space: derive it from {right}"):
        type("Nowhere", (base,), body)
    assert "test-nowhere" not in base.kinds


def with_row(name: str, row: str, quantity: str) -> type:
    """The parabola with another name and quantity of its row."""

    def constraint(self, scene):
        (same,) = ParabolaGuide.constraint(self, scene)
        return (Row(row, quantity, same.form, same.law),)

    return type(name, (ParabolaGuide,), {"kind": "", "constraint": constraint, "__module__": __name__})


def test_a_row_that_measures_nothing_known_is_refused_by_name(directory):
    kind = with_row("Odd", "height", "lenght")
    scene = Case("odd", kind, {"steepness": 0.6}, ("rod", "ground"), ("A", "A"), "A").scene(directory)
    with pytest.raises(
        InputError, match=r"row 'height' of joint 'component' measures 'lenght'; .* one of: length, angle.* class Odd"
    ):
        compile_scene(scene)


def test_a_row_is_an_angle_because_its_joint_says_so_whatever_its_name(directory):
    """Angles count in rad, lengths in parts of the model size."""
    found = {}
    for quantity in ("length", "angle"):
        kind = with_row("Named", "rotation of nothing", quantity)
        scene = Case("named", kind, {"steepness": 0.6}, ("rod", "ground"), ("A", "A"), "A").scene(directory)
        found[quantity] = compile_scene(scene).weights[-1]
    assert found == {"length": pytest.approx(1 / loaded(scene).size, rel=1e-15), "angle": 1.0}


def test_two_components_of_one_kind_share_one_formula(directory):
    scene = Case("parabola", ParabolaGuide, {"steepness": 0.6}, ("rod", "ground"), ("A", "A"), "A").scene(directory)
    again = scene.joints["component"].model_copy(update={"steepness": 0.7})
    twice = scene.model_copy(update={"joints": {**scene.joints, "again": again}})
    assert laws_of(list(twice.joints.values())) == [parabola]
    check_state_derivatives(twice)


def test_pins_are_what_the_formulas_of_all_joints_make_of_them():
    """Of rigid and of elastic bodies, with and without a frame: the short formulas and the general ones differ by round-off."""
    scene = read_scene(WING)
    system = compile_scene(scene, list(scene.design))
    assert system.plan.joints.of[:, PINNED].any()
    of = system.plan.joints.of.copy()
    of[:, PINNED] = 0
    general = replace(system, plan=system.plan._replace(joints=system.plan.joints._replace(of=of)))
    state = random_state(system)
    for ours, theirs in zip(*(each.evaluate(inputs(each), *state, design=True) for each in (system, general)), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-14 * np.abs(theirs).max())


def test_rows_that_feel_no_translation_have_no_entry_there():
    """A pin's row along x feels x and the angle of a bar: every entry more costs each factorisation."""
    system = compile_scene(four_bars(1))
    names, pattern = system.numbering.names, system.matrix(np.ones(len(system.plan.indices)))
    for row in range(system.n_q, system.n):
        other = {"x": "y of body", "y": "x of body"}[names[row][0]]
        felt = [names[column] for column in pattern[[row]].indices if column < system.n_q]
        assert felt
        assert not any(name.startswith(other) for name in felt)
