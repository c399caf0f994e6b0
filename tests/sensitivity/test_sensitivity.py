"""Gradients of whole runs: direct differentiation against complex step, differences and Taylor's formula."""

import numpy as np
import pytest

import ffrf
from preprocessing import build
from tests.models.directions import along, derivative_along, direction
from tests.models.scenes import HANGING_DESIGN, MODELS, WING, hanging_skin
from toolkit.analyses.sensitivity.certificate.differences import step_study, taylor_rates
from toolkit.analyses.sensitivity.direct import direct, numerical
from toolkit.analyses.sensitivity.preparation import prepare, values_of
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.rigid import Rod
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.revolute import Revolute
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError, NoDerivativeError
from toolkit.reduced_model.file import save
from toolkit.responses.motion import Rotation
from toolkit.scene.scene import Scene
from toolkit.solvers.start import initial_conditions

AGREEMENT = 5e-10
"""Two orders of the same sums, for a skin that is 1e6 times stiffer in stretching than in bending: seen are 2e-10 in statics and
7e-11 in motions, whatever the tolerance of Newton's method; a skin that is four times thicker leaves 2e-11. The last digit of the
stored stiffness alone moves the gradients by 5e-9, but both of them alike."""


def largest_difference(reference: dict[str, dict[str, float]], other: dict[str, dict[str, float]]) -> float:
    """Largest relative difference of two sets of gradients, entry by entry."""
    pairs = [(reference[name][x], other[name][x]) for name in reference for x in reference[name]]
    return max(abs(a - b) / max(abs(a), np.finfo(float).tiny) for a, b in pairs)


@pytest.mark.processors
@pytest.mark.parametrize("kind", ["static", "transient"])
def test_gradients_of_the_wing_agree_with_the_complex_step(kind):
    scene = read_scene(WING)
    names = list(scene.design)
    ours, judge = direct(scene, names, kind), numerical(scene, names, kind, "complex-step")
    assert set(ours.gradients) == {"max_stress", "max_stress_true", "shape_rmse", "shape_max_error", "drive_angle"}
    assert largest_difference(judge.gradients, ours.gradients) < AGREEMENT


@pytest.mark.parametrize("kind", ["static", "transient"])
def test_taylor_remainder_of_the_wing_is_of_second_order(kind):
    scene = read_scene(WING)
    rates = taylor_rates(scene, list(scene.design), kind, steps=(2e-3, 1e-3, 5e-4))
    # shape_rmse adds 60 squares of changing sign, so that its fitted rate is the furthest from the asymptotic 2
    assert all(1.85 < rate < 2.15 for rate in rates.values()), rates


@pytest.mark.parametrize("scheme", ["paper", "arnold-bruels"])
def test_gradients_of_every_kind_of_response_agree_with_the_complex_step(scheme):
    scene = hanging_skin(solver=RunOptions(end_time=0.01, step=0.001, scheme=scheme, rho_inf=0.7))
    ours = direct(scene, HANGING_DESIGN, "transient")
    # entries differ by many powers of ten in their effect, so each response is compared with its largest relative effect
    factors = {path: part * max(abs(scene.number(path)), 1.0) for path, part in direction(HANGING_DESIGN).items()}
    for name, judge in derivative_along(scene, factors, "transient", ours.solution).items():
        slopes = ours.gradients[name]
        effects = [abs(slopes[path] * factor) for path, factor in factors.items()]
        assert along(slopes, factors) == pytest.approx(judge, rel=0, abs=1e-8 * max(effects)), name


@pytest.mark.processors
def test_central_differences_form_a_v_whose_bottom_confirms_the_gradient():
    scene = read_scene(WING)
    study = dict(step_study(scene, ["M_t"], "transient", steps=(1e-1, 1e-2, 1e-3, 1e-4, 1e-8, 1e-11)))
    assert study[1e-2] / study[1e-1] == pytest.approx(1e-2, rel=0.9)  # truncation falls with the square of the step
    # bottom: the square of the step, 2e-8, or the round-off of a run, 1e-13, over it, 1e-9
    assert min(study.values()) < 1e-6
    # and that round-off over the other steps, 1e-5 and 1e-2, of the response that has most of it; twenty times less or more is chance
    assert 5e-7 < study[1e-8] < 2e-4
    assert 5e-4 < study[1e-11] < 2e-1


def test_forward_differences_of_the_paper_agree_to_their_own_accuracy():
    scene = read_scene(WING)
    ours = direct(scene, ["M_t"], "transient").gradients
    judge = numerical(scene, ["M_t"], "transient", "forward-difference").gradients
    assert largest_difference(ours, judge) < 2e-3  # 1e-6 relative step: round-off of the state, amplified a million times


@pytest.mark.parametrize("kind", ["static", "transient"])
def test_an_interface_point_moves_along_the_skin(kind, tmp_path):
    """The reference scene with C off a node: the gradient by its arc length, against complex step and a skin meshed anew."""
    gradient = direct(_wing_with_c_at(98.0, tmp_path), ["points.C.arc_length"], kind).gradients
    judge = numerical(_wing_with_c_at(98.0, tmp_path), ["points.C.arc_length"], kind, "complex-step").gradients
    assert largest_difference(judge, gradient) < AGREEMENT
    up, down = (values_of(_wing_with_c_at(s, tmp_path), kind)["drive_angle"] for s in (98.01, 97.99))
    # truncation of the difference, about (step / element length)^2 = 1e-6
    assert gradient["drive_angle"]["points.C.arc_length"] == pytest.approx((up - down) / 0.02, rel=1e-4)


def _wing_with_c_at(arc_length, folder):
    for file in ("high_speed.dat", "low_speed.dat", "scene.toml"):
        (folder / file).write_bytes((MODELS / file).read_bytes())
    skin = (MODELS / "skin.toml").read_text().replace("C = { node = 10 }", f"C = {{ arc_length = {arc_length} }}")
    (folder / "skin.toml").write_text(skin)
    save(build(folder / "skin.toml"), folder / "skin.h5")
    return read_scene(folder / "scene.toml")


def test_velocities_that_the_joints_find_at_the_start_are_differentiated():
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.2)},
        bodies={"rod": Rod(between=("O", "P"), area=1e-3, density=2700.0, angular_velocity=0.4)},
        joints={"O": Revolute(bodies=("rod", "ground"), point="O")},
        responses={"angle": Rotation(body="rod", point="P")},
        solver=RunOptions(end_time=0.5, step=0.05),
    )
    design = ["points.P.x", "points.P.y", "bodies.rod.angular_velocity", "bodies.rod.density"]
    ours, judge = direct(scene, design, "transient"), numerical(scene, design, "transient", "complex-step")
    for name in ("points.P.x", "points.P.y", "bodies.rod.angular_velocity"):
        assert ours.gradients["angle"][name] == pytest.approx(judge.gradients["angle"][name], rel=1e-10)
    # the motion of a free pendulum does not depend on its density: both are round-off of a number of order one
    assert abs(ours.gradients["angle"]["bodies.rod.density"]) < 1e-12


def test_a_design_variable_that_breaks_a_joint_at_the_start_is_refused_by_name():
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0), "Q": Point(x=1.0, y=1.0)},
        bodies={"rod": Rod(between=("O", "P"), area=1e-3, density=2700.0)},
        joints={"bar": Distance(bodies=("rod", "ground"), points=("P", "Q"), length=1.0)},
        responses={"angle": Rotation(body="rod", point="P")},
    )
    with pytest.raises(InputError, match=r"'joints.bar.length' would violate distance of joint 'bar'"):
        direct(scene, ["joints.bar.length"], "transient")


def test_all_variables_that_break_joints_at_the_start_are_told_however_many_are_looked_at_together(monkeypatch):
    bodies = {name: Rod(between=("O", "P"), area=1e-3, density=2700.0) for name in ("one", "other")}
    scene = Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=1.0, y=0.0), "Q": Point(x=1.0, y=1.0)},
        bodies=bodies,
        joints={name: Distance(bodies=(name, "ground"), points=("P", "Q"), length=1.0) for name in bodies},
        responses={"angle": Rotation(body="one", point="P")},
    )
    design = ["joints.other.length", "points.P.x", "bodies.one.density", "joints.one.length"]
    for together in (64, 2, 1):
        monkeypatch.setattr(initial_conditions, "VARIABLES_AT_ONCE", together)
        with pytest.raises(NoDerivativeError, match=r"'joints.one.length' would violate distance of joint 'one'") as caught:
            direct(scene, design, "transient")
        assert caught.value.variables == ("joints.other.length", "joints.one.length")


def test_an_unknown_method_lists_the_available_ones():
    with pytest.raises(
        InputError, match="available: auto, direct, adjoint, complex-step, forward-difference, central-difference"
    ):
        numerical(read_scene(WING), ["M_t"], "static", "magic")


def test_a_complex_step_along_the_known_motion_finds_the_same_in_fewer_iterations():
    scene = read_scene(WING, {"solver.end_time": "0.2"})
    run, path = simulate(prepare(scene)), scene.design["t_w"]
    system = prepare(scene.with_number(path, scene.number(path) + 1e-30j))
    alone, beside = simulate(system), simulate(system, along=run)
    assert (
        beside.newton_iterations == 2 * run.steps < alone.newton_iterations
    )  # one finds the derivative, and one that it is right
    exact = alone.q.imag
    np.testing.assert_allclose(beside.q.imag, exact, rtol=0, atol=1e-10 * np.abs(exact).max())


def test_a_variable_that_nothing_feels_is_told():
    """Rods have no weight in this equilibrium; their densities are felt by the motion."""
    model = ffrf.compile(read_scene(WING), variables=["t_w", "bodies.body2.density"])
    found = {kind: getattr(model, kind)(gradients=True) for kind in ("statics", "simulate")}
    told = {kind: [each for each in run.verdict.warnings if each.code == "unfelt"] for kind, run in found.items()}
    assert told["simulate"] == []
    assert [each.doubt for each in told["statics"]] == [False]
    assert "bodies.body2.density" in told["statics"][0].text
    assert "t_w" not in told["statics"][0].text
