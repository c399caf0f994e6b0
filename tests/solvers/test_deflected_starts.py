"""Flexible bodies that start bent or bending: the shape is that of forces at the written points, and the motion what theory says of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import ffrf
from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from tests.models.cases import write_models
from tests.models.spatial_cases import write_models as write_spatial_models
from toolkit.analyses.modes import undeformed
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.description.design import BodyPoint
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.responses.point_motion import Deflection
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.studies.stability.maps import speed_map
from toolkit.system.system import compile_scene
from toolkit.validity.start_cautions import cautions_of_start, start_lines, start_record

MODELS = Path(__file__).parents[2] / "models"
BENT = {2: (0.02, -0.03), 3: (0.02, -0.03, 0.01)}
RATE = {2: (-0.4, 0.1), 3: (0.1, 0.3, -0.2)}
END = 0.8


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    write_spatial_models(directory)
    section = Section(youngs_modulus=2e11, density=7800.0, thickness=0.01, width=0.02)
    nodes = np.column_stack([np.linspace(0, 1, 5), np.zeros(5)])
    save_beam(directory / "steel.h5", nodes, section, {"root": 0.0, "middle": 0.5, "tip": 1.0})
    return directory


def alone(folder: Path, dimension: int, loads: dict[str, Any] | None = None, **body: Any) -> Scene:
    """A damped body with numbers of order one, clamped to the ground, turned, and gripped at two points."""
    kinds: Any = ffrf.plane if dimension == 2 else ffrf.space
    turned = {"angle": 0.7} if dimension == 2 else {"orientation": (0.3, -0.5, 0.7)}
    model = "beam.h5" if dimension == 2 else "frame.h5"
    return Scene(
        units="m-kg-s",
        dimension=dimension,
        directory=folder,
        points={name: BodyPoint(body="arm", interface=place) for name, place in (("T", "middle"), ("U", "end"))},
        bodies={"arm": kinds.Flexible(model=model, frame="grounded", **turned, **body)},
        loads=loads or {},
        responses={"u": Deflection(body="arm", point="U", component="y")},
        solver=RunOptions(end_time=END, step=END / 800, rho_inf=1.0),
    )


def matrices(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, damping and stiffness of the body as its file has them."""
    inv = scene.model(scene.bodies["arm"].model).invariants  # type: ignore[attr-defined]
    return inv.inertia_about_origin[1:, 1:], inv.damping, inv.stiffness


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_shape_is_that_of_forces_at_the_written_points(folder, dimension):
    """Two forces bend the body at rest; what they do to their points, written as a deflection, gives all of its coordinates."""
    kinds: Any = ffrf.plane if dimension == 2 else ffrf.space
    forces = {"T": (0.02, -0.01, 0.03), "U": (-0.01, 0.01, 0.02)}
    loads = {point: kinds.PointForce(body="arm", point=point, force=force[:dimension]) for point, force in forces.items()}
    held = solve_statics(compile_scene(alone(folder, dimension, loads)))
    arm: Any = held.system.scene.bodies["arm"]
    found = {point: arm.point(held.system.scene, point, "arm")[0][:, 1:] @ held.q[-1] for point in forces}
    bent = compile_scene(alone(folder, dimension, deflection={point: tuple(map(float, u)) for point, u in found.items()}))
    # statics stops at 1e-10 of the model size
    np.testing.assert_allclose(bent.start()[0], held.q[-1], rtol=0, atol=1e-9 * np.abs(held.q[-1]).max())


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_body_that_is_let_go_vibrates_as_its_matrices_say(folder, dimension):
    """[q; v](t) = exp(A t) [q; v](0), A = [[0, 1], [-M^-1 K, -M^-1 D]]."""
    scene = alone(folder, dimension, deflection={"U": BENT[dimension]}, elastic_velocity={"T": RATE[dimension]})
    run = simulate(compile_scene(scene))
    M, D, K = matrices(scene)
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    arm: Any = scene.bodies["arm"]
    Z_T, Z_U = (arm.point(loaded(scene), point, "arm")[0][:, 1:] for point in "TU")
    np.testing.assert_allclose(Z_U @ run.q[0], BENT[dimension], rtol=1e-12)
    np.testing.assert_allclose(Z_T @ run.v[0], RATE[dimension], rtol=1e-12)
    exact = (expm(A * END) @ np.concatenate([run.q[0], run.v[0]]))[:n]
    lowest = np.abs(Z_U @ exact).max()
    errors = []
    for steps in (800, 1600):
        options = scene.solver.model_copy(update={"step": END / steps})
        errors.append(np.abs(Z_U @ (simulate(compile_scene(scene), options).q[-1] - exact)).max())
    assert errors[1] < 1e-3 * lowest
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)  # second order in the step


def test_a_plucked_cantilever_has_the_cubic_of_its_tip_force(folder):
    """u(x) / u(L) = (3 s^2 - s^3) / 2 of a force at the tip, s = x / L; and the energy 3 E I u^2 / (2 L^3)."""
    scene = cantilever(folder, deflection={"T": (0.0, 0.01)}, frame="grounded")
    run = simulate(compile_scene(scene))
    beam: Any = scene.bodies["beam"]
    middle = beam.point(loaded(scene), "M", "beam")[0][:, 1:] @ run.q[0]
    assert middle[1] == pytest.approx(0.01 * (3 / 4 - 1 / 8) / 2, rel=1e-9)
    K = scene.model("steel.h5").invariants.stiffness
    assert run.q[0] @ K @ run.q[0] / 2 == pytest.approx(1.5 * 2e11 * 0.02 * 0.01**3 / 12 * 0.01**2, rel=1e-9)
    assert run.verdict.trusted
    assert start_lines(run)[0].startswith("beam starts with a deflection of")
    record = start_record(run)["beam"]
    assert (record["deforming"]["used"], record["deforming"]["written"]) == (0.0, None)


def test_a_rod_between_two_pins_that_is_plucked_in_its_middle_vibrates_in_closed_form():
    """u(t) = u_0 96 / pi^4 sum_n cos(w_n t) / n^4 over odd n, w_n = (n pi / L)^2 sqrt(E I / (rho A)), of a rod whose frame is its chord."""
    kinds, u, time = ffrf.plane, 1e-3, 4e-3
    scene = Scene(
        units="m-kg-s",
        directory=MODELS / "flexible_slider_crank",
        points={name: BodyPoint(body="rod", interface=name) for name in "AMB"},
        bodies={"rod": kinds.Flexible(model="frame.h5", deflection={"M": (0.0, u)})},
        joints={name: kinds.Revolute(bodies=("rod", "ground"), point=name) for name in "AB"},
        responses={"u": kinds.Displacement(body="rod", point="M", component="y")},
        solver=RunOptions(end_time=time, step=4e-6, rho_inf=1.0),
    )
    number = np.arange(1, 20, 2)
    own = (number * np.pi / 0.3) ** 2 * np.sqrt(2e11 * 0.006**2 / 12 / 7870)
    expected = u * 96 / np.pi**4 * np.sum(np.cos(own * time) / number**4)
    run = ffrf.compile(scene, ["bodies.rod.deflection.M.y"]).simulate(gradients="adjoint")
    # four modes in each half have the frequencies of n = 1 and 3 to 1e-3, and others than the rod from n = 5 on: out of phase by then
    rest = 2 * 96 / np.pi**4 * np.sum(number[2:] ** -4.0)
    assert run.values["u"] == pytest.approx(expected, abs=rest * u)
    assert run.gradients["u"]["bodies.rod.deflection.M.y"] == pytest.approx(expected / u, abs=rest)
    assert rest < 0.006 * abs(expected / u)


def cantilever(folder: Path, joints: dict[str, Any] | None = None, solver: dict[str, Any] | None = None, **body: Any) -> Scene:
    """A steel beam of 1 m, with joints to the ground."""
    places = {"R": "root", "M": "middle", "T": "tip"}
    return Scene(
        units="m-kg-s",
        directory=folder,
        points={name: BodyPoint(body="beam", interface=place) for name, place in places.items()},
        bodies={"beam": ffrf.plane.Flexible(model="steel.h5", **body)},
        joints=joints or {},
        solver=RunOptions(**({"end_time": 1e-3, "step": 1e-4} | (solver or {}))),
    )


def pinned(*points: str) -> dict[str, Any]:
    return {point: ffrf.plane.Revolute(bodies=("beam", "ground"), point=point) for point in points}


def test_responses_still_count_from_the_undeformed_body(folder):
    scene = cantilever(folder, deflection={"T": (0.0, 0.01)}, frame="grounded")
    moved = ffrf.plane.Displacement(body="beam", point="T", component="y", time=0.0)
    run = ffrf.compile(scene.model_copy(update={"responses": {"y": moved}}), ["bodies.beam.deflection.T.y"]).simulate(
        gradients=True
    )
    assert run.values["y"] == pytest.approx(0.01, rel=1e-12)
    assert run.gradients["y"]["bodies.beam.deflection.T.y"] == pytest.approx(1.0, rel=1e-12)


def test_an_equilibrium_has_no_use_for_a_deflection_and_says_so(folder):
    scene = cantilever(folder, deflection={"T": (0.0, 0.01)}, frame="grounded")
    still = solve_statics(compile_scene(scene))
    assert not np.any(still.q)
    assert not np.any(undeformed(compile_scene(scene)).q)
    begun = simulate(compile_scene(scene.model_copy(update={"solver": scene.solver.model_copy(update={"start": "equilibrium"})})))
    assert not np.any(begun.q)
    for run in (still, begun):
        assert "deflection-without-effect" in {caution.code for caution in cautions_of_start(run)}


def test_a_written_rate_of_bending_holds_beside_what_the_joints_find(folder):
    """On a hinge at its root the beam's frame rests, and its tip moves as it is written."""
    scene = cantilever(folder, pinned("R"), elastic_velocity={"T": (0.0, 0.2)})
    run = simulate(compile_scene(scene))
    beam: Any = scene.bodies["beam"]
    assert not np.any(run.v[0, :3])
    assert (beam.point(loaded(scene), "T", "beam")[0][:, 1:] @ run.v[0, 3:])[1] == pytest.approx(0.2, rel=1e-12)
    assert not list(cautions_of_start(run))  # it begins to vibrate because it is told to


def test_a_map_over_the_speed_takes_rates_of_bending_along(folder):
    scene = alone(folder, 2, deflection={"U": BENT[2]}, elastic_velocity={"T": RATE[2]})
    found = speed_map(scene)
    for (k,), faster in found.scenes.items():
        by = float(found.axes[0].values[k])
        assert faster.number("bodies.arm.elastic_velocity.T.x") == pytest.approx(by * RATE[2][0])
        assert faster.number("bodies.arm.deflection.U.x") == BENT[2][0]


# --- refused, or told ---------------------------------------------------------------------------------------------------------------


def test_a_deflection_that_opens_a_joint_is_refused_or_closed_and_told(folder):
    scene = cantilever(folder, pinned("R", "T"), deflection={"T": (0.0, 0.01)})
    with pytest.raises(InputError, match=r"inconsistent start: y of joint 'T' is violated by 0\.01 .*solver\.assemble = true"):
        simulate(compile_scene(scene))
    run = simulate(compile_scene(cantilever(folder, pinned("R", "T"), {"assemble": True}, deflection={"T": (0.0, 0.01)})))
    told = {caution.text for caution in cautions_of_start(run) if caution.code == "assembled"}
    assert any(text.startswith("solver.assemble moved bodies") for text in told)  # it turns the beam rather than bends it back


def test_closing_that_bends_a_body_back_is_told(folder):
    """Pinned to the ground at the root and above its middle, the beam can only turn, and its tip's deflection cannot stay."""
    joints = pinned("R") | {"M": ffrf.plane.RigidJoint(bodies=("beam", "ground"), point="M")}
    run = simulate(compile_scene(cantilever(folder, joints, {"assemble": True}, deflection={"T": (0.0, 0.01)})))
    (text,) = (c.text for c in cautions_of_start(run) if c.text.startswith("solver.assemble bent"))
    assert "its deflection at point 'T' is [" in text
    assert text.endswith("instead of the written [0, 0.01] m.")


def test_a_rate_that_the_joints_do_not_allow_is_refused_with_both_numbers(folder):
    scene = cantilever(folder, pinned("R", "T"), angular_velocity=0.3, elastic_velocity={"M": (0.0, 0.2)})
    with pytest.raises(
        InputError, match=r"bodies\.beam\.elastic_velocity is written as .* m/s of elastic coordinate .*write also those points"
    ):
        simulate(compile_scene(scene))


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ({"X": (0.0, 1.0)}, r"bodies\.beam\.deflection names point 'X', which does not exist"),
        (
            {"R": (0.0, 0.01)},
            r"bodies\.beam\.deflection\.R asks for a displacement along y .* no deformation of the body moves the point",
        ),
        ({"T": (0.01, 0.0), "U": (0.0, 0.01)}, r"do not allow each on its own: T\.x, T\.y, U\.x, U\.y"),
        ({"O": (0.0, 0.01)}, "point 'O' is not an interface point of flexible body 'beam'"),
    ],
)
def test_a_deflection_that_cannot_be_is_refused(folder, written, message):
    def refused() -> None:
        scene = cantilever(folder, frame="grounded")
        points = {**scene.points, "U": BodyPoint(body="beam", interface="tip"), "O": ffrf.plane.Point(x=0.0, y=0.0)}
        bodies = {"beam": scene.bodies["beam"].model_copy(update={"deflection": written})}
        compile_scene(Scene(**{**dict(scene), "points": points, "bodies": bodies}))

    with pytest.raises((InputError, ValueError), match=message):
        refused()


def test_a_rigid_body_has_no_deflection(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(
        'units = "m-kg-s"\npoints = { O = [0.0, 0.0], P = [1.0, 0.0] }\n'
        '[bodies]\nrod = { type = "rod", between = ["O", "P"], area = 1.0, density = 1.0, deflection = { P = [0.0, 0.1] } }\n'
    )
    with pytest.raises(InputError, match=r"bodies\.rod\.deflection: unknown key"):
        read_scene(path)


def test_the_axes_of_a_deflection_in_space_have_names_too(folder):
    scene = alone(folder, 3, deflection={"U": BENT[3]})
    assert scene.number("bodies.arm.deflection.U.z") == scene.number("bodies.arm.deflection.U.2") == BENT[3][2]
    assert scene.path_of("bodies.arm.deflection.U.z") == "bodies.arm.deflection.U.2"
