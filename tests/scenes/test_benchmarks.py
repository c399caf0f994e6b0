"""Published and closed-form benchmarks: pendulum, N-four-bar, slider-crank with gradients, beams, arch and ring."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from tests.models.four_bars import four_bars
from toolkit.analyses.modes import solve_modes, undeformed
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.joints.distance import Distance
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.point_force import PointForce
from toolkit.components.loads.springs import SpringDamper
from toolkit.components.loads.torque import Torque
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.reduced_model.file import load
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

DATA = Path(__file__).parents[1] / "data" / "benchmarks"
GRAVITY = Gravity(acceleration=(0.0, -9.81))


def benchmark(name: str) -> dict:
    return json.loads((DATA / f"{name}.json").read_text())


def at(**places: tuple[float, float]) -> dict[str, Point]:
    return {name: Point(x=x, y=y) for name, (x, y) in places.items()}


def rows(solution: Solution, times: list[float]) -> np.ndarray:
    """Numbers of the steps at the times."""
    return np.rint(np.array(times) / solution.times[1]).astype(int)


def extrapolated(coarse: list, fine: list) -> list:
    """What remains of results at h and h / 2 after the error in h^2 is taken out."""
    return [b + (b - a) / 3 for a, b in zip(coarse, fine, strict=True)]


# --- IFToMM A01: the pendulum -------------------------------------------------------------------------------------------------


def pendulum(step: float, times: list[float]) -> list[np.ndarray]:
    """theta, dtheta/dL, dtheta/dg and the rod's force; L through the point P, theta from the downward vertical."""
    scene = Scene(
        units="m-kg-s",
        points=at(O=(0, 0), P=(-1, 0)),
        bodies={"mass": Rigid(mass=1.0, inertia=1.0, center="P")},
        joints={"rod": Distance(bodies=("mass", "ground"), points=("P", "O"))},
        loads={"gravity": GRAVITY},
    )
    system = compile_scene(scene, ["points.P.x", "loads.gravity.acceleration.y"])
    run = simulate(system, RunOptions(end_time=10.0, step=step, rho_inf=1.0))
    n = rows(run, times)
    x, y = run.q[n, 0], run.q[n, 1]
    by_path = (x[:, None] * run.dq[n, 1] - y[:, None] * run.dq[n, 0]) / (x**2 + y**2)[:, None]
    return [np.arctan2(x, -y), -by_path[:, 0], -by_path[:, 1], run.multipliers[n, 0]]


def test_pendulum_and_its_design_derivatives_match_the_elliptic_functions():
    known = benchmark("iftomm_a01_pendulum")["rederived"]
    exact = [np.array(known[key]) for key in ("theta_rad", "dtheta_dL", "dtheta_dg", "rod_tension_N")]
    coarse, fine = (pendulum(step, known["t"]) for step in (1e-3, 5e-4))
    for ours, finer, better, reference in zip(coarse, fine, extrapolated(coarse, fine), exact, strict=True):
        size = np.abs(reference).max()
        errors = [np.abs(result - reference).max() / size for result in (ours, finer, better)]
        assert errors[1] < 3e-5  # second order: phase error of 4 periods of 4700 steps
        assert 3.8 < errors[0] / errors[1] < 4.2
        assert errors[2] < 1e-6  # fourth order is left: an error of another kind would stay


# --- IFToMM A02: N four-bar linkages in a row -----------------------------------------------------------------------------------


def four_bar_errors(count: int, step: float) -> tuple[float, float]:
    """Largest drift of energy (relative) and error of the angle in 10 s, through ten singular positions."""
    known = benchmark("iftomm_a02_n_fourbar")["rederived"][f"N={count}"]
    run = simulate(compile_scene(four_bars(count)), RunOptions(end_time=10.0, step=step, rho_inf=0.8))
    q, v = run.q.reshape(len(run.times), -1, 3), run.v.reshape(len(run.times), -1, 3)
    energy = (v**2 @ [1, 1, 1 / 12]).sum(axis=1) / 2 + 9.81 * q[:, :, 1].sum(axis=1)
    assert energy[0] == pytest.approx(known["total_energy_J"], rel=1e-12)
    angle = -q[rows(run, known["t"]), 0, 2]
    return np.abs(energy / energy[0] - 1).max(), np.abs(angle - known["phi_rad"]).max()


def test_two_four_bars_pass_singular_positions_and_converge_in_energy_and_angle():
    coarse, fine = four_bar_errors(2, 1e-3), four_bar_errors(2, 5e-4)
    assert fine[0] < 1e-5  # second order: 9 J of 36 J swing with 7 rad/s, (7 x 5e-4)^2
    assert fine[1] < 1e-4  # the phase error grows with time
    assert all(3.8 < a / b < 5.5 for a, b in zip(coarse, fine, strict=True))  # 4, a little more at singular positions


def test_forty_four_bars_stay_on_their_branch():
    energy, angle = four_bar_errors(40, 5e-3)
    assert energy < 2e-3  # at a step a hundred times coarser than the error of 1e-7 asks for
    assert angle < 0.05


# --- SUNDIALS slider-crank ------------------------------------------------------------------------------------------------------

CRANK, ROD = 0.5, 1.0
PIN = np.sqrt(ROD**2 - CRANK**2)
D_PIN = {"a": -CRANK / PIN, "L": ROD / PIN}
CHAIN = {
    "k": {"loads.spring.stiffness": 1.0},
    "c": {"loads.spring.damping": 1.0},
    "l0": {"loads.spring.length": 1.0},
    "F": {"loads.force.force.x": 1.0},
    "J1": {"bodies.crank.inertia": 1.0},
    "J2": {"bodies.rod.inertia": 1.0},
    "m2": {"bodies.rod.mass": 1.0},
    "a": {
        "points.T.y": 1.0, "points.H.y": 0.5, "points.X.x": D_PIN["a"], "points.M.x": D_PIN["a"] / 2, "points.M.y": 0.5,
        "points.W.x": 2 * D_PIN["a"], "points.W.y": -1.0,
    },
    "L": {"points.X.x": D_PIN["L"], "points.M.x": D_PIN["L"] / 2, "points.W.x": 2 * D_PIN["L"]},
}  # fmt: skip
"""Parameters of the benchmark by the numbers of the scene: the points follow from crank radius a and rod length L."""


def slider_crank() -> Scene:
    """Crank tip T at (0, a), its middle H; rod from T to the pin X on the x axis, its middle M; W the mirror image of T at X."""
    return Scene(
        units="m-kg-s",
        points=at(O=(0, 0), T=(0, CRANK), H=(0, CRANK / 2), X=(PIN, 0), M=(PIN / 2, CRANK / 2), W=(2 * PIN, -CRANK)),
        bodies={"crank": Rigid(mass=1.0, inertia=1.0, center="O"), "rod": Rigid(mass=1.0, inertia=2.0, center="X")},
        joints={
            "O": Revolute(bodies=("crank", "ground"), point="O"),
            "T": Revolute(bodies=("crank", "rod"), point="T"),
            "X": Slider(bodies=("rod", "ground"), point="X"),
        },
        loads={
            "spring": SpringDamper(bodies=("crank", "rod"), points=("H", "M"), stiffness=1.0, damping=1.0, length=1.0),
            "force": PointForce(body="rod", point="W", force=(1.0, 0.0)),
        },
    )


def functional(step: float) -> tuple[float, dict[str, float], dict[str, np.ndarray]]:
    """G = int T dt (trapezoidal rule), dG/dp, and d(q, q')/dp at the end, with q the crank's angle."""
    paths = sorted({path for chain in CHAIN.values() for path in chain})
    run = simulate(compile_scene(slider_crank(), paths), RunOptions(end_time=10.0, step=step, rho_inf=1.0))
    weights = np.full(len(run.times), step)
    weights[[0, -1]] /= 2
    masses, v = np.array([1.0, 1.0, 2.0]), run.v[:, [2, 3, 5]]  # J1 q', m2 x', J2 p'
    value = weights @ (v**2 @ masses) / 2
    by_path = np.einsum("t,ti,i,tix->x", weights, v, masses, run.dv[:, [2, 3, 5]])
    explicit = dict(zip(("J1", "m2", "J2"), weights @ v**2 / 2, strict=True))

    def total(name: str, derivative: np.ndarray) -> np.ndarray:
        return sum(factor * derivative[..., paths.index(path)] for path, factor in CHAIN[name].items())

    gradient = {name: total(name, by_path) + explicit.get(name, 0.0) for name in CHAIN}
    return value, gradient, {name: np.array([total(name, run.dq[-1, 2]), total(name, run.dv[-1, 2])]) for name in CHAIN}


@pytest.fixture(scope="module")
def slider_crank_results():
    return functional(0.01), functional(0.005)


def test_slider_crank_matches_the_published_functional_and_gradients(slider_crank_results):
    known = benchmark("sundials_slider_crank_sensitivity")
    value, gradient, _ = slider_crank_results[1]
    assert value == pytest.approx(known["reference"]["G_idas_forward"], rel=5e-5)  # second order at 0.005
    for name, published in zip(("k", "c"), known["reference"]["dG_dp_idas"], strict=True):
        assert gradient[name] == pytest.approx(published, rel=known["tolerance"]["published_gradient_rel"])


def test_slider_crank_gradients_by_all_nine_parameters_converge_to_the_complex_step_values(slider_crank_results):
    known = benchmark("sundials_slider_crank_sensitivity")["rederived"]
    (g_1, d_1, e_1), (g_2, d_2, e_2) = slider_crank_results
    assert g_2 + (g_2 - g_1) / 3 == pytest.approx(known["G"], rel=1e-7)  # higher order is left, (0.005 / 1)^3
    for name, exact in known["dG_d"].items():
        assert d_2[name] + (d_2[name] - d_1[name]) / 3 == pytest.approx(exact, rel=1e-6), name
        assert abs(d_2[name] - exact) < 0.3 * abs(d_1[name] - exact), name  # second order: 0.25
    for name, exact in known["dq_dqd_t10_d"].items():
        np.testing.assert_allclose(e_2[name] + (e_2[name] - e_1[name]) / 3, exact, rtol=1e-5, err_msg=name)


def test_slider_crank_positions_match_the_published_table():
    known = benchmark("sundials_slider_crank_sensitivity")["reference"]
    run = simulate(compile_scene(slider_crank()), RunOptions(end_time=10.0, step=0.005))
    n = rows(run, known["table_t"])
    ours = np.column_stack([np.pi / 2 + run.q[n, 2], run.q[n, 3], -np.pi / 6 + run.q[n, 5]])
    np.testing.assert_allclose(ours, known["table_q_x_p"], atol=1e-4)  # the printed digits


# --- beams, arch, ring ----------------------------------------------------------------------------------------------------------

STRUCTURES = benchmark("structural_analytic")
KNOWN = STRUCTURES["reference"]
E, RHO, B, T = (STRUCTURES["parameters"]["beam"][key] for key in ("E_Pa", "rho", "b_m", "h_m"))
SECTION = Section(youngs_modulus=E, density=RHO, thickness=T, width=B)
EI, MASS_PER_LENGTH = E * B * T**3 / 12, RHO * B * T
EXACT = 1e-9
"""Beam elements are exact for forces at nodes; condition of the stiffness 1e6 times round-off."""


def straight(
    directory: Path, elements: int, frame: str = "grounded", joints: dict | None = None, loads: dict | None = None
) -> Scene:
    """A beam of 1 m along x; points 'root', 'middle', 'tip'; grounded at its root, or with a moving frame and joints."""
    nodes = np.column_stack([np.linspace(0, 1, elements + 1), np.zeros(elements + 1)])
    return structure(directory, nodes, frame, joints or {}, loads or {})


def structure(directory: Path, nodes: np.ndarray, frame: str, joints: dict, loads: dict) -> Scene:
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()
    save_beam(directory / "beam.h5", nodes, SECTION, {"root": 0.0, "middle": length / 2, "tip": length})
    points = {name: BodyPoint(body="beam", interface=name) for name in ("root", "middle", "tip")}
    bodies = {"beam": Flexible(model="beam.h5", frame=frame)}
    return Scene(units="m-kg-s", points=points, bodies=bodies, joints=joints, loads=loads, directory=directory)


def quarter(elements: int) -> np.ndarray:
    """Quarter circle of radius R from (R, 0) to (0, R)."""
    angle = np.linspace(0, np.pi / 2, elements + 1)
    return STRUCTURES["parameters"]["arch"]["R_m"] * np.column_stack([np.cos(angle), np.sin(angle)])


def displacement(scene: Scene) -> np.ndarray:
    """Static solution: per free node x, y, rotation in the body's frame; before them the frame's, if it moves."""
    return solve_statics(compile_scene(scene), RunOptions(load_steps=1)).q[0].reshape(-1, 3)


def held(point: str, slide: bool = False, lock: bool = False) -> dict:
    """A support of the beam: pinned, or sliding along x; with its rotation locked or free."""
    if slide:
        return {point: Slider(bodies=("beam", "ground"), point=point, lock_rotation=lock)}
    return {point: Revolute(bodies=("beam", "ground"), point=point)}


def test_cantilever_under_a_tip_force_has_the_textbook_deflection_and_stress(tmp_path):
    force = STRUCTURES["parameters"]["tip_force_N"]
    loads = {"tip": PointForce(body="beam", point="tip", force=(0.0, force))}
    u = displacement(straight(tmp_path, 4, loads=loads))
    assert u[-1, 1] == pytest.approx(KNOWN["cantilever_tip_force_deflection_m"], rel=EXACT)
    assert u[-1, 2] == pytest.approx(KNOWN["cantilever_tip_force_rotation_rad"], rel=EXACT)
    stress = load(tmp_path / "beam.h5").invariants.stress_operator @ u.ravel()
    profile = np.abs(stress.reshape(4, 2, 2)[:, 0, 0])
    np.testing.assert_allclose(profile, KNOWN["cantilever_bending_stress_profile_Pa_at_x0_quarters"], rtol=EXACT)


def test_cantilever_under_its_weight_has_the_deflection_of_a_line_load(tmp_path):
    load_per_length = STRUCTURES["parameters"]["line_load_N_per_m"]
    loads = {"gravity": Gravity(acceleration=(0.0, load_per_length / MASS_PER_LENGTH))}
    u = displacement(straight(tmp_path, 4, loads=loads))
    assert u[-1, 1] == pytest.approx(KNOWN["cantilever_line_load_deflection_m"], rel=EXACT)  # consistent loads: exact at nodes


def test_beams_on_two_supports_have_the_textbook_deflections(tmp_path):
    force = {"middle": PointForce(body="beam", point="middle", force=(0.0, -10.0))}
    simply = displacement(straight(tmp_path, 4, "moving", held("root") | held("tip", slide=True), force))
    clamped = displacement(straight(tmp_path, 4, joints=held("tip", slide=True, lock=True), loads=force))
    frame, middle = simply[0], simply[2]
    height = frame[1] + np.sin(frame[2]) * (0.5 + middle[0]) + np.cos(frame[2]) * middle[1]
    # the frame turns with the end slope P L^2 / (16 E I) = 0.0021: its square is the geometric nonlinearity
    assert -height == pytest.approx(KNOWN["simply_supported_mid_force_deflection_m"], rel=1e-5)
    assert -clamped[1, 1] == pytest.approx(KNOWN["clamped_clamped_mid_force_deflection_m"], rel=EXACT)


def frequencies(scene: Scene, count: int) -> np.ndarray:
    """Lowest frequencies about the undeformed state."""
    return solve_modes(undeformed(compile_scene(scene)), count).frequencies


@pytest.mark.parametrize("elements", [1, 2, 4, 8])
def test_cantilever_frequencies_are_the_algebraic_ones_of_consistent_elements(tmp_path, elements):
    known = np.array(KNOWN[f"cantilever_consistent_FE_n{elements}_omega_nd"])
    ours = 2 * np.pi * frequencies(straight(tmp_path, elements), 8) * np.sqrt(MASS_PER_LENGTH / EI)
    for value in known:
        assert np.abs(ours / value - 1).min() < EXACT  # axial frequencies lie between them


def test_two_beams_joined_rigidly_are_one_beam(tmp_path):
    """Half a cantilever, and another half that moves with its own frame, joined at the point of each: same modes."""
    whole = frequencies(straight(tmp_path, 8), 6)
    nodes = np.column_stack([np.linspace(0, 0.5, 5), np.zeros(5)])
    save_beam(tmp_path / "half.h5", nodes, SECTION, {"root": 0.0, "tip": 0.5})
    ends = {"P": ("one", "tip"), "Q": ("two", "root"), "T": ("two", "tip")}
    scene = Scene(
        units="m-kg-s",
        directory=tmp_path,
        points={name: BodyPoint(body=body, interface=end) for name, (body, end) in ends.items()},
        bodies={"one": Flexible(model="half.h5", frame="grounded"), "two": Flexible(model="half.h5", position=(0.5, 0.0))},
        joints={"weld": RigidJoint(bodies=("one", "two"), point=("P", "Q"))},
    )
    # EXACT is round-off of the finite elements; the extra coordinates of the second frame cost a digit or two
    np.testing.assert_allclose(frequencies(scene, 6), whole, rtol=100 * EXACT)


SUPPORTS = {
    "clamped_free": ("grounded", {}),
    "clamped_clamped": ("grounded", held("tip", slide=True, lock=True)),
    "clamped_pinned": ("grounded", held("tip", slide=True)),
    "pinned_pinned": ("moving", held("root") | held("tip", slide=True)),
    "free_free": ("moving", {}),
}


@pytest.mark.parametrize("supports", SUPPORTS)
def test_bending_frequencies_converge_with_fourth_order_for_all_supports(tmp_path, supports):
    frame, joints = SUPPORTS[supports]
    rigid = 3 if supports == "free_free" else 0
    known = np.array(KNOWN[f"f_Hz_bending_{supports}"])[:3]
    errors = [np.abs(frequencies(straight(tmp_path, n, frame, joints), rigid + 3)[rigid:] / known - 1) for n in (8, 16)]
    assert errors[1].max() < 3e-4  # (k h)^4 / 720 of the third mode on 16 elements, k = 11: 3.1e-4
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 4.0, atol=0.35)  # fourth order; the third mode is not asymptotic


def test_axial_frequencies_converge_to_those_of_a_bar(tmp_path):
    known = KNOWN["f_Hz_axial_fixed_free"][0]
    found = []
    for elements in (8, 16):
        ours = frequencies(straight(tmp_path, elements), 3 * elements)
        found.append(np.abs(ours / known - 1).min())
    assert found[1] < 5e-4  # (pi / 2)^2 / 24 / 16^2
    assert np.log2(found[0] / found[1]) == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("direction", ["Fx", "Fy", "M"])
def test_a_quarter_arch_of_straight_elements_converges_with_second_order(tmp_path, direction):
    known = np.array(KNOWN[f"quarter_arch_tip_disp_for_unit_{direction}"])
    force = {"Fx": (1.0, 0.0), "Fy": (0.0, 1.0)}
    loads = {
        "tip": PointForce(body="beam", point="tip", force=force[direction])
        if direction in force
        else Torque(body="beam", point="tip", torque=1.0)
    }
    errors = []
    for elements in (16, 32):
        u = displacement(structure(tmp_path, quarter(elements), "grounded", {}, loads))[-1]
        errors.append(np.abs(u - known).max() / np.abs(known).max())
    assert errors[1] < 5e-4  # the chord of an element is (pi / 2 / 32)^2 / 24 too short, the area under it likewise: 1e-4 each
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)


def test_a_pinched_ring_by_symmetry_of_a_quarter(tmp_path):
    """Half the force on the guided end; the exact value has the extension pi P R / (4 E A) on top of the inextensible one."""
    radius, force = 0.5, 20.0
    loads = {"pinch": PointForce(body="beam", point="tip", force=(0.0, force / 2))}
    joints = {"guide": Slider(bodies=("beam", "ground"), point="tip", axis=(0.0, 1.0), lock_rotation=True)}
    guide = {"root": Slider(bodies=("beam", "ground"), point="root", axis=(1.0, 0.0), lock_rotation=True)}
    exact = KNOWN["pinched_ring_diameter_change_coeff"] * force * radius**3 / EI + np.pi * force * radius / (4 * E * B * T)
    errors = []
    for elements in (16, 32):
        scene = structure(tmp_path, quarter(elements), "moving", joints | guide, loads)
        run = solve_statics(compile_scene(scene), RunOptions(load_steps=1))
        errors.append(2 * (run.q[0, 1] + run.q[0, -2]) / exact - 1)
    assert abs(errors[1]) < 1e-3  # second order in the angle of an element
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_even_ring_modes_by_symmetry_of_a_quarter(tmp_path):
    """n = 2 and 4 of the extensible ring, symmetric to both axes."""
    joints = {
        "root": Slider(bodies=("beam", "ground"), point="root", axis=(1.0, 0.0), lock_rotation=True),
        "tip": Slider(bodies=("beam", "ground"), point="tip", axis=(0.0, 1.0), lock_rotation=True),
    }
    known = np.array(KNOWN["ring_extensible_omega_nd_for_this_section"])[[0, 2]]
    errors = []
    for elements in (16, 32):
        ours = 2 * np.pi * frequencies(structure(tmp_path, quarter(elements), "moving", joints, {}), 2)
        errors.append(np.abs(ours * np.sqrt(MASS_PER_LENGTH * 0.5**4 / EI) / known - 1))
    assert errors[1].max() < 2e-3  # second order in the angle of an element
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 2.0, atol=0.1)
