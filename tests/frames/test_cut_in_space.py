"""Spatial beams cut into parts with frames of their own, against exact rods, published positions, the plane and the complex step."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

import ffrf
from tests.frames.test_cut_bodies import agree
from tests.models.spatial_chains import WHERE, chain_scene, save_chain
from tests.spatial.momenta import kinetic_energy, momentum, strain_energy, turning
from toolkit.analyses.statics import solve_statics
from toolkit.api.model import Model
from toolkit.foundation.errors import InputError
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of, skew
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.file import load
from toolkit.render.space.configuration import SpatialConfiguration, body_shape
from toolkit.render.space.parts import spatial_symbols
from toolkit.scene.resolution import resolve
from toolkit.system.system import compile_scene

RADIUS, FORCE = 100.0, 600.0
"""The bend of Bathe and Bolourchi (1979): one eighth of a circle, a square of side 1, a force out of its plane."""
SECTION = f'kind = "general", area = 1.0, I_y = {1 / 12}, I_z = {1 / 12}, J = {1 / 6}, I_p = {1 / 6}'
YOUNG = 1e7
PUBLISHED = np.array([47.23, 15.79, 53.37])
"""Tip of 8 elements by Simo and Vu-Quoc, Comput. Methods Appl. Mech. Engrg. 58 (1986), with the torsion constant 1/6."""
TURNED = (0.3, -0.5, 0.8)
"""Rotation vector of a body that stands askew."""


def bend(folder, elements, frames, orientation=(0.0, 0.0, 0.0)):
    """Displacement and undeformed place of the tip in the axes of the body, the force turned with it."""
    angle = np.linspace(0, np.pi / 4, elements + 1)
    nodes = RADIUS * np.column_stack([np.sin(angle), 1 - np.cos(angle), 0 * angle])
    if not (folder / "beam.h5").exists():
        save_chain(folder, nodes, SECTION, YOUNG, 0.0)
    A = matrix_of(quaternion_of(np.array(orientation)))
    force = [float(x) for x in A @ [0.0, 0.0, FORCE]]
    load = f'[loads]\npull = {{ type = "point-force", body = "beam", point = "tip", force = {force} }}\n[responses]\n{WHERE}'
    place = f"position = [1.0, 2.0, 3.0], orientation = {list(orientation)}"
    scene = chain_scene(folder, f'frame = "grounded", frames = {frames}, {place}', load)
    found = ffrf.compile(scene).statics().values
    return A.T @ [found[axis] for axis in "xyz"], nodes[-1]


def exact_tip(guess: np.ndarray) -> np.ndarray:
    """Tip of the extensible rod without shear, from its differential equations: the clamp's moment is found by shooting.

    r' = (1 + F . t / EA) t,   R' = R skew(k),   M' = F x r',   t = R e_1,   k = C^-1 R^T M + k_0,   M(L) = 0
    """
    force, length = np.array([0.0, 0.0, FORCE]), RADIUS * np.pi / 4
    stiff, curved = YOUNG / 12 * np.array([1.0, 1.0, 1.0]), np.array([0.0, 0.0, 1 / RADIUS])

    def rate(_, y):
        R = y[3:12].reshape(3, 3)
        along = (1 + force @ R[:, 0] / YOUNG) * R[:, 0]
        return np.concatenate([along, (R @ skew(R.T @ y[12:] / stiff + curved)).ravel(), np.cross(force, along)])

    def end(moment):
        start = np.concatenate([np.zeros(3), np.eye(3).ravel(), moment])
        return solve_ivp(rate, (0, length), start, method="DOP853", rtol=1e-9, atol=1e-8).y[:, -1]

    size = FORCE * length
    found = root(lambda moment: end(size * moment)[12:] / size, np.cross(guess, force) / size, tol=1e-10)
    assert found.success
    return end(size * found.x)[:3]


def test_a_force_bends_an_arc_out_of_its_plane(tmp_path):
    """One frame to an element converges to the exact rod with the square of their number; a body that stands askew bends the same."""
    exact, errors = exact_tip(PUBLISHED), []
    for elements in (4, 8):
        folder = tmp_path / str(elements)
        folder.mkdir()
        moved, at = bend(folder, elements, elements)
        errors.append(np.linalg.norm(at + moved - exact))
    size = np.linalg.norm(moved)
    assert errors[0] > 3.8 * errors[1]  # of second order
    assert errors[1] < 1.2e-3 * size
    assert np.linalg.norm(at + moved - PUBLISHED) < 4e-3 * size  # what 8 elements of theirs and their shear leave
    few, _ = bend(tmp_path / "8", 8, 4)
    assert np.linalg.norm(at + few - exact) < 8e-3 * size  # each part turns by about a quarter of 1 rad
    askew, _ = bend(tmp_path / "8", 8, 4, TURNED)
    np.testing.assert_allclose(askew, few, atol=1e-8 * size)  # statics end at 1e-10 of the size


def test_a_moment_rolls_a_beam_up_in_an_inclined_plane(tmp_path):
    """Every chord turns by the same angle, so that the nodes lie on a regular polygon, which closes after a full turn."""
    n, e_i = 6, 1e9 * 0.02 * 0.01**3 / 12
    save_chain(tmp_path, np.column_stack([np.linspace(0, 1, n + 1), np.zeros((n + 1, 2))]))
    A = matrix_of(quaternion_of(np.array(TURNED)))
    torque = [float(x) for x in A @ [0.0, 0.0, 2 * np.pi * e_i]]
    rest = f'[loads]\nroll = {{ type = "torque", body = "beam", point = "tip", torque = {torque} }}\n[responses]\n{WHERE}'
    scene = chain_scene(tmp_path, f'frame = "grounded", frames = {n}, orientation = {list(TURNED)}', rest)
    found = ffrf.compile(scene).statics().values
    np.testing.assert_allclose(A.T @ [found[axis] for axis in "xyz"], [-1.0, 0.0, 0.0], atol=1e-8)  # statics end at 1e-10


@pytest.fixture(scope="module")
def flat_and_spatial(tmp_path_factory):
    """Values of an arc with three frames in the plane, and of the same one laid in space."""
    angle, found = np.linspace(0, 1.2, 7), {}
    arc = np.column_stack([np.sin(angle), 1 - np.cos(angle)])
    for dimension, zero, turn in ((2, "", "0.3"), (3, ", 0.0", "[0.0, 0.0, 0.3]")):
        folder = tmp_path_factory.mktemp(f"{dimension}")
        save_chain(folder, np.column_stack([arc, np.zeros((7, dimension - 2))]))
        rest = f"""[loads]
pull = {{ type = "point-force", body = "beam", point = "tip", force = [-1.0, 2.0{zero}] }}
turn = {{ type = "torque", body = "beam", point = "middle", torque = {turn} }}
[responses]
{WHERE if dimension == 3 else WHERE[: WHERE.index("z =")]}
stress = {{ type = "max-stress", body = "beam", measure = "absolute" }}
strain = {{ type = "strain-energy", body = "beam" }}
"""
        found[dimension] = ffrf.compile(chain_scene(folder, 'frame = "grounded", frames = 3', rest, dimension)).statics().values
    return found


def test_a_beam_in_the_plane_bends_as_the_same_beam_in_space(flat_and_spatial):
    """Place, stress and energy agree to what both solvers leave; out of the plane nothing moves."""
    flat, spatial = flat_and_spatial[2], flat_and_spatial[3]
    assert flat["strain"] > 0.1
    assert abs(spatial["z"]) < 1e-12
    for name, value in flat.items():
        assert spatial[name] == pytest.approx(value, rel=1e-7), name  # statics end at 1e-10 of the size, stress is E times that


SWING = """[joints]
hub = { type = "spherical", bodies = ["beam", "ground"], point = "root" }
[loads]
weight = { type = "gravity", acceleration = [0.0, 2.0, -9.81] }
pull = { type = "point-force", body = "beam", point = "tip", force = [0.0, 0.3, 0.1], frame = "body" }
[design]
t = "bodies.beam.thickness_s"
z = "bodies.beam.z_N2"
omega = "bodies.beam.angular_velocity.z"
turned = "bodies.beam.orientation.y"
[responses]
y = { type = "acceleration", body = "beam", point = "middle", component = "y" }
stress = { type = "ks-stress", body = "beam", aggregation = 10.0, reference_stress = 1e6 }
strain = { type = "strain-energy", body = "beam" }
centre = { type = "centre-of-mass", component = "y" }
hub = { type = "joint-force", joint = "hub", component = "magnitude" }
[solver]
end_time = 0.006
step = 0.002
rho_inf = 0.8
"""
CROOKED = np.array([[0.0, 0, 0], [0.3, 0.05, 0], [0.5, 0.1, 0.1], [0.8, 0.1, 0.2], [1.0, 0.0, 0.3]])


def test_gradients_of_a_crooked_beam_that_swings_are_complex_steps(tmp_path):
    """By a thickness, the place of a node at a cut, which turns two chords, and the start; direct, adjoint and complex step."""
    save_chain(tmp_path, CROOKED, damping=1e-3)
    body = "frames = 2, orientation = [0.1, 0.2, 0.3], angular_velocity = [0.3, 0.5, 1.5]"
    scene = chain_scene(tmp_path, body, SWING)
    agree(ffrf.compile(scene, variables=["t", "z", "omega", "turned"]), "simulate")


FREE = """[loads]
pull = { type = "point-force", body = "beam", point = "tip", force = [0.0, 0.6, 0.3], curve = PULSE }
turn = { type = "torque", body = "beam", point = "root", torque = [0.01, 0.02, 0.02], curve = PULSE }
[solver]
end_time = 0.15
step = 0.002
rho_inf = 0.95
formulation = "ggl"
""".replace("PULSE", '{ type = "table", times = [0.0, 0.05, 0.1], values = [0.0, 1.0, 0.0] }')


def test_a_bent_beam_that_flies_freely_keeps_energy_and_momenta(tmp_path):
    """After a pulse that has bent it nothing acts: what energy and momenta change by is the scheme's, of second order in the step."""
    save_chain(tmp_path, np.column_stack([np.linspace(0, 1, 5), np.zeros((5, 2))]), young=2e7)
    changes = changes_in_flight(ffrf.compile(chain_scene(tmp_path, "frames = 4, angular_velocity = [0.3, 0.5, 1.5]", FREE)))
    assert max(changes[1]) < 0.02
    assert all(coarse > 3.3 * fine for coarse, fine in zip(*changes, strict=True))


def changes_in_flight(model: Model, pulse: float = 0.1, steps: tuple[float, float] = (0.002, 0.001)) -> list[list[float]]:
    """By how much momentum, angular momentum and energy change after a pulse, in parts of what they are, with both lengths of steps."""
    changes = []
    for step in steps:
        solution = model.simulate({"solver.step": step}).solution
        system, kept = solution.system, []
        for q, v in list(zip(solution.q, solution.v, strict=True))[round(pulse / step) :]:
            conjugate, total = momentum(system, q, v), np.zeros(6)
            for at in (system.numbering.first[name] for name in system.scene.pieces()):
                own = conjugate[at : at + 3]
                total += [*own, *(np.cross(q[at : at + 3], own) + turning(q[at + 3 : at + 7]) @ conjugate[at + 3 : at + 7])]
            kept.append([*total, strain_energy(system, q), kinetic_energy(system, q, v)])
        found = np.array(kept)
        energy = found[:, 6:].sum(axis=1)
        assert found[:, 6].max() > 0.1 * energy[0]  # it is bent, and swings
        sizes = [np.abs(found[:, part]).max() for part in (slice(3), slice(3, 6))]
        changes.append(
            [np.ptp(found[:, part], axis=0).max() / size for part, size in zip((slice(3), slice(3, 6)), sizes, strict=True)]
        )
        changes[-1].append(np.ptp(energy) / energy[0])
    return changes


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of a beam of four elements."""
    found = tmp_path_factory.mktemp("crooked")
    save_chain(found, CROOKED)
    return found


@pytest.fixture(scope="module")
def beam(folder):
    """A clamped beam with two frames, under a force."""
    rest = f"""[loads]
pull = {{ type = "point-force", body = "beam", point = "tip", force = [0.0, 0.3, 0.5] }}
[responses]
{WHERE}"""
    return chain_scene(folder, 'frame = "grounded", frames = 2', rest)


def test_to_the_scene_it_stays_one_body(beam):
    cut = resolve(beam)
    assert list(cut.all_bodies()) == ["ground", "beam", "beam[1]", "beam[2]"]
    assert list(cut.joints) == ["beam at node 2", "beam at node 0"]
    assert cut.written == beam
    assert dict(resolve(cut.written)) == dict(cut)
    assert beam.available_paths() == cut.available_paths()


def test_pictures_show_one_body_without_steps(beam):
    """Fibres of both parts meet at the cut, one clamp is drawn and no tie, and stress is that of the whole body."""
    solution = solve_statics(compile_scene(beam))
    moment = SpatialConfiguration(solution, 0)
    shape = body_shape(moment, "beam")
    ends, starts = shape.points[shape.lines[4:8, 1]], shape.points[shape.lines[8:12, 0]]
    np.testing.assert_allclose(ends.mean(axis=0), starts.mean(axis=0), atol=1e-9)  # the tie, to 1e-10 of the size
    assert np.all(np.isfinite(shape.stress))
    assert [symbol.kind for symbol in spatial_symbols(moment)] == ["weld", "pin"]  # the clamp, and the tip
    np.testing.assert_allclose(moment.position("beam", "tip"), shape.points[shape.lines[-4:, 1]].mean(axis=0), atol=1e-12)


def test_parts_are_the_same_in_other_units(folder):
    """The energy of a displacement of an element, which mixes lengths and angles."""
    model = load(folder / "beam.h5")
    other = converted_model(model, "mm-t-s")
    u = np.tile([1.0, 2.0, 3.0, 0.1, 0.2, 0.3], 2) * np.repeat([1.0, -0.5], 6)
    v = u * np.tile([1e3] * 3 + [1.0] * 3, 2)
    assert model.elements is not None
    assert other.elements is not None
    for one, its in zip(model.elements.stiffness, other.elements.stiffness, strict=True):
        assert v @ its @ v == pytest.approx(1e3 * (u @ one @ u), rel=1e-12)  # J in N mm


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ('frame = "turning", axis = [0.0, 0.0, 1.0], frames = 2', 'frame = "turning" belongs to a body with one frame'),
        ("frames = 5", "has 4 elements, and a frame needs one at least. Write at most 4"),
        ('frames = ["tip"]', "cuts at node 4, where an end of the body is already"),
        ("frames = 2, deflection = { tip = [0.0, 0.1, 0.0] }", "is the shape of a body with one frame"),
    ],
)
def test_what_a_cut_body_cannot_be_is_refused(folder, words, message):
    with pytest.raises(InputError, match=message.replace("[", r"\[")):
        compile_scene(chain_scene(folder, words, ""))


SPUN = """[joints]
axis = { type = "revolute", bodies = ["beam", "ground"], point = "root"AXIS }
motor = { type = "angle-driver", bodies = ["beam", "ground"], point = "root"AXIS, curve = TURNS }
[responses]
first = { type = "frequency" }
[solver]
equilibrium = "spinning"
"""
FLAP = 6.4495
"""First flap frequency of a beam that spins with 5 times sqrt(EI / m L^4), in these units, for a hub without radius."""


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_beam_that_spins_stiffens(tmp_path, dimension):
    """Its parts pull at each other: 4 frames give the flap frequency to 1 %, one frame nothing of it; in the plane there is lag alone."""
    nodes = np.column_stack([np.linspace(0, 1, 9), np.zeros((9, dimension - 1))])
    save_chain(tmp_path, nodes, 'kind = "rectangle", thickness = 0.005, width = 0.02', orientation=(0.0, 1.0, 0.0))
    unit = np.sqrt(1e9 * 0.005**2 / 12 / 1000)
    wanted = FLAP if dimension == 3 else np.sqrt(FLAP**2 - 25)  # in the plane the force of inertia turns with the beam
    turns = f'{{ type = "polynomial", coefficients = [0.0, {5 * unit}] }}'
    text = SPUN.replace("TURNS", turns).replace("AXIS", ", axis = [0.0, 0.0, 1.0]" if dimension == 3 else "")
    run = ffrf.compile(chain_scene(tmp_path, "frames = 4", text, dimension)).statics()
    found = run.values["first"] * 2 * np.pi / unit
    assert found == pytest.approx(wanted, rel=0.01 * (FLAP / wanted) ** 2)  # the same part of the square
    assert abs(found - wanted) > 0.001 * wanted  # no accident: the error of 4 frames is there
    (said,) = (each.text for each in run.verdict.warnings if each.code == "missing-stiffening")
    told = float(said.partition("by about ")[2].partition("%")[0]) / 100
    assert told == pytest.approx(1 - found / wanted, rel=0.1)  # a rule that is measured, at one of its points; printed to 0.1 %
    assert "frames = 7 leaves about 1%" in said


def test_cuts_where_a_spinning_beam_bends_most_stiffen_it_most(tmp_path):
    """At ten times the unit of speed four equal frames lack 1.3 % of the published flap frequency, unequal ones a third of that, and the
    meter knows it."""
    nodes = np.column_stack([np.linspace(0, 1, 9), np.zeros((9, 2))])
    save_chain(tmp_path, nodes, 'kind = "rectangle", thickness = 0.005, width = 0.02', orientation=(0.0, 1.0, 0.0))
    unit, lacks = np.sqrt(1e9 * 0.005**2 / 12 / 1000), {}
    turns = f'{{ type = "polynomial", coefficients = [0.0, {10 * unit}] }}'
    text = SPUN.replace("TURNS", turns).replace("AXIS", ", axis = [0.0, 0.0, 1.0]")
    for frames in ("4", "[1, 2, 4]"):
        run = ffrf.compile(chain_scene(tmp_path, f"frames = {frames}", text)).statics()
        lacks[frames] = 1 - run.values["first"] * 2 * np.pi / unit / 11.2023
        (said,) = (each.text for each in run.verdict.warnings if each.code == "missing-stiffening")
        told = float(said.partition("by about ")[2].partition("%")[0]) / 100
        assert lacks[frames] / 1.5 < told < 1.5 * lacks[frames]
    assert 0.01 < lacks["4"] < 0.015
    assert lacks["[1, 2, 4]"] < 0.006


def test_a_motion_goes_on_from_a_kept_one(folder):
    """A results file keeps a cut body as it was written, and the places and velocities of all its parts."""
    rest = f"[responses]\n{WHERE}[solver]\nend_time = 0.004\nstep = 0.002\n"
    body = "frames = 2, angular_velocity = [0.3, 0.5, 1.5]"
    kept = ffrf.compile(chain_scene(folder, body, rest)).simulate()
    kept.save(folder / "kept.h5")
    late = ffrf.compile(chain_scene(folder, body, rest + 'start = "kept.h5"\n')).simulate()
    for state in ("q", "v"):
        one, other = getattr(kept.solution, state)[-1], getattr(late.solution, state)[0]
        np.testing.assert_allclose(other, one, atol=1e-5 * np.abs(one).max())  # what the first run has left open is closed
