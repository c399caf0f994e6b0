"""Solids that are cut into named groups of elements: against the elastica, the uncut mesh, other builds and the complex step."""

from __future__ import annotations

from dataclasses import replace

import meshio
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import ffrf
from preprocessing import build, save
from tests.frames.test_cut_bodies import agree
from tests.frames.test_cut_in_space import FLAP, SPUN, changes_in_flight
from tests.models.solid_bodies import compliance, frequencies
from tests.models.solid_pieces import LENGTHS, YOUNG, bar_scene, save_bar, write_bar
from tests.models.spatial_chains import WHERE as OF_BEAM
from toolkit.analyses.statics import solve_statics
from toolkit.foundation.errors import InputError, ModelFileError
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.file import load
from toolkit.reduced_model.parts import Pieces
from toolkit.render.space.configuration import SpatialConfiguration, body_shape
from toolkit.render.space.parts import spatial_symbols
from toolkit.scene.resolution import resolve
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.bent_surfaces import shortening
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.bodies.few_shapes import raised_at_most

pytestmark = pytest.mark.usefixtures("all_read_here")

WHERE = OF_BEAM.replace('"beam"', '"bar"')
STIFFNESS = YOUNG * LENGTHS[1] * LENGTHS[2] ** 3 / 12
"""E I of bending in the plane of x and z."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory, all_read_here):
    """Of a bar of four pieces, with a variable that makes it thicker towards its tip and bends it, and its model."""
    found = tmp_path_factory.mktemp("bar")
    write_bar(found, 4, cells=CELLS)
    nodes = meshio.read(found / "bar.inp").points
    field = np.column_stack([0 * nodes[:, 0], 0.2 * nodes[:, 0] ** 2, nodes[:, 0] * nodes[:, 2]])
    np.save(found / "taper.npy", field)
    save_bar(found, 4, cells=CELLS, more='[shape_variables]\ntaper.field = "taper.npy"\n' + TOP)
    return found


CELLS = (8, 1, 1)
TOP = f"[pressure_surfaces.top]\nbox = [0, {-LENGTHS[1]}, {LENGTHS[2] / 2}, 1, {LENGTHS[1]}, {LENGTHS[2] / 2}]\n"


def pulled(force, side=0.0):
    """A load across the tip."""
    return f'[loads]\npull = {{ type = "point-force", body = "bar", point = "tip", force = [0.0, {side!r}, {force!r}] }}\n'


def elastica(force: float, stiffness: float) -> np.ndarray:
    """x and z of the tip of an inextensible cantilever of length 1 without shear: E I theta'' = -F cos theta."""

    def end(curvature):
        def rate(_, y):
            return [y[1], -force / stiffness * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

        return solve_ivp(rate, (0, 1), [0, curvature, 0, 0], rtol=1e-10, atol=1e-12).y[:, -1]

    return end(brentq(lambda curvature: end(curvature)[1], 0.0, 10.0))[2:]


def test_a_solid_bends_as_the_elastica(folder):
    """By half a right angle: the error of the tip falls with the square of the frames, and with as many as there are pieces what is left
    is what these bend inside, which the meter knows. The elastica is as stiff as mesh and shear make the bar in the small."""
    force = 2 * STIFFNESS
    stiffness = 1 / (3 * compliance(load(folder / "bar.h5"))[2, 2])
    exact, errors = elastica(force, stiffness) - [1.0, 0.0], {}
    model = ffrf.compile(bar_scene(folder, 'frame = "grounded", frames = 4', pulled(force) + f"[responses]\n{WHERE}"))
    runs = {4: model.statics()}
    for frames in (1, 2):
        scene = bar_scene(folder, f'frame = "grounded", frames = {frames}', pulled(force) + f"[responses]\n{WHERE}")
        runs[frames] = ffrf.compile(scene).statics()
    for frames, run in runs.items():
        errors[frames] = np.linalg.norm([run.values["x"], run.values["z"]] - exact) / np.linalg.norm(exact)
    assert errors[1] > 0.4  # one frame is no answer, and says so
    assert not runs[1].verdict.trusted
    assert errors[2] > 3.5 * errors[4]
    assert errors[4] < 0.006
    told, turn, count = shortening(runs[4].solution, "bar")
    assert count == 4
    assert 0.15 < turn < 0.25  # a piece turns by up to 0.35 rad from end to end, not the same at both
    assert errors[4] < told < 3 * errors[4]  # a coarse mesh bends far a little otherwise than near, by 0.2 %


def test_a_pressure_that_follows_bends_a_solid_as_it_bends_a_beam(tmp_path):
    """E I theta'' = -V, T' = V theta', V' = -T theta' - p b from the free end on, where all but theta is zero; with one frame it is linear
    theory, p b L^4 / 8 E I."""
    load = 4 * STIFFNESS  # per length

    def rate(_, y):
        angle, curvature, along, across = y[:4]
        return [curvature, -across / STIFFNESS, across * curvature, -along * curvature - load, np.cos(angle), np.sin(angle)]

    back = solve_ivp(rate, (1, 0), np.zeros(6), rtol=1e-10, atol=1e-12).y[:, -1]
    c, s = np.cos(back[0]), np.sin(back[0])
    tip = np.array([[c, s], [s, -c]]) @ -back[4:]  # along the clamped end and across
    save_bar(tmp_path, 4, cells=CELLS, ratio=0.0, more=TOP)
    rest = f'[loads]\nwind = {{ type = "pressure", body = "bar", surface = "top", pressure = {load / LENGTHS[1]!r} }}\n[responses]\n{WHERE}'
    found = {n: ffrf.compile(bar_scene(tmp_path, f'frame = "grounded", frames = {n}', rest)).statics() for n in (1, 2, 4)}
    moved = {n: np.array([run.values["x"] + 1, run.values["z"]]) for n, run in found.items()}
    off = {n: float(np.linalg.norm(place - tip)) for n, place in moved.items()}
    assert moved[1][1] == pytest.approx(
        -0.5, rel=3e-3
    )  # two elements of the mesh to a piece are too stiff by 0.3 %, shear adds 0.1 %
    assert off[1] > 0.1
    assert off[2] < 0.01
    assert off[4] < 0.5 * off[2]  # a quarter, but for the mesh and shear
    assert [run.verdict.trusted for run in found.values()] == [False, True, True]


def test_what_a_pressure_does_inside_of_pieces_is_said(folder):
    """Between clamped ends stress lacks p l^2 / 12 of p L^2 / 12, a sixteenth with four pieces; their ends are where they should be."""
    held = '[joints]\nwall = { type = "rigid", bodies = ["bar", "ground"], point = "tip" }\n'
    load = '[loads]\nwind = { type = "pressure", body = "bar", surface = "top", pressure = 10.0 }\n'
    asked = '[responses]\nstress = { type = "max-stress", body = "bar" }\n'
    for frames in (1, 4):
        run = ffrf.compile(bar_scene(folder, f'frame = "grounded", frames = {frames}', held + load + asked)).statics()
        (said,) = [each.text for each in run.verdict.warnings if each.code == "weight-between-nodes"]
        assert "lacks what pressures on it do between nodes" in said
        assert "some 6% of the largest" in said


def test_gradients_that_are_zero_by_symmetry_have_no_sign_to_doubt(folder):
    """Two frames are too few for x, and y is round-off."""
    load = f'[loads]\nwind = {{ type = "pressure", body = "bar", surface = "top", pressure = {2 * STIFFNESS / LENGTHS[1]!r} }}\n'
    asked = f'[design]\np = "loads.wind.pressure"\n[responses]\n{WHERE}first = {{ type = "frequency", number = 1 }}\n'
    run = ffrf.compile(bar_scene(folder, 'frame = "grounded", frames = 2', load + asked), variables=["p"]).statics(gradients=True)
    errors = run.verdict.measures["geometric_error"]
    assert run.values["y"] == pytest.approx(0.0, abs=1e-10)  # statics end there
    assert errors["gradients"]["y"]["p"] != 0
    assert errors["signs_in_doubt"] == []


def test_a_moment_rolls_a_solid_up(tmp_path):
    """Without contraction across, pieces with averaged faces bend exactly: the chords of six are a hexagon, which closes."""
    save_bar(tmp_path, 6, cells=(6, 1, 1), ratio=0.0)
    torque = [0.0, -2 * np.pi * STIFFNESS, 0.0]
    rest = f'[loads]\nroll = {{ type = "torque", body = "bar", point = "tip", torque = {torque} }}\n[responses]\n{WHERE}'
    run = ffrf.compile(bar_scene(tmp_path, 'frame = "grounded", frames = 6', rest)).statics()
    np.testing.assert_allclose([run.values[axis] for axis in "xyz"], [-1.0, 0.0, 0.0], atol=1e-8)  # statics end at 1e-10


@pytest.fixture(scope="module")
def by_faces(tmp_path_factory, all_read_here):
    """The uncut bar, and that of two pieces with each kind of faces."""
    found = {}
    for faces in ("uncut", "averaged", "rigid"):
        there = tmp_path_factory.mktemp(faces)
        found[faces] = save_bar(there, 0 if faces == "uncut" else 2, faces=faces, cells=(4, 1, 1), lengths=(0.4, 0.05, 0.04))
    return found


def test_faces_make_a_body_softer_or_stiffer_by_what_its_model_says(by_faces):
    """The compliance of the uncut mesh lies between; the file tells by how much, of the worst forces together and of each."""
    exact = compliance(by_faces["uncut"])
    for faces, sign in (("averaged", 1), ("rigid", -1)):
        model = by_faces[faces]
        found, told = compliance(model), model.face_errors
        values = np.linalg.eigvals(np.linalg.solve(exact, found)).real - 1
        assert min(sign * values) > -1e-6  # below that errors are round-off
        assert 1e-3 < max(sign * values) < 0.03
        np.testing.assert_allclose([told["least"], told["largest"]], [values.min(), values.max()], atol=2e-6)
        singles = np.diag(found) / np.diag(exact) - 1
        np.testing.assert_allclose([value for name, value in told.items() if " at tip" in name], singles, atol=2e-6)


def test_pieces_weigh_what_the_body_weighs(by_faces):
    """Mass, its moments, and the force of gravity on shapes that both have."""
    uncut, cut = by_faces["uncut"].invariants, by_faces["rigid"].invariants
    for name in ("mass", "first_moment", "second_moment"):
        one, other = (getattr(each, name) for each in (uncut, cut))
        one, other = (each[..., 0] if each.ndim == 2 else each[..., 0, 0] if each.ndim else each for each in (one, other))
        np.testing.assert_allclose(other, one, atol=1e-12 * np.abs(one).max())  # round-off


def test_a_cut_solid_vibrates_as_the_uncut_one(folder, tmp_path):
    """Shapes at rest of four pieces stand for the lowest modes, as those of beam elements do: to less than a part in 1000 for the first
    bending frequencies in both planes, to one percent for the second."""
    write_bar(tmp_path, 0, cells=CELLS)
    toml = tmp_path / "bar.toml"
    toml.write_text(toml.read_text().replace('basis.kind = "static"', 'basis = { kind = "craig-bampton", count = 12 }'))
    other = build(toml)
    one, its = (frequencies(model) for model in (load(folder / "bar.h5"), other))
    np.testing.assert_allclose(one[:2], its[:2], rtol=1e-3)
    np.testing.assert_allclose(one[:4], its[:4], rtol=1e-2)
    true = one[:10] / its[:10] - 1
    slowest = load(folder / "bar.h5").left_out["interface"]
    told = np.array([raised_at_most(each, slowest) for each in one[:10]])
    assert np.all(true < told)
    assert np.any(true > 0.4 * told)


def test_what_pieces_leave_out_of_frequencies_is_said(folder):
    """Torsion and stretch too, whatever the number of frames, by the slowest vibration between their ends."""
    asked = [f"[responses.f{k}]\ntype = 'frequency'\nnumber = {k}\n" for k in (1, 9)]
    for frames in ("", ", frames = 4"):
        run = ffrf.compile(bar_scene(folder, 'frame = "grounded"' + frames, "".join(asked))).statics()
        (said,) = [each for each in run.verdict.warnings if each.code in ("left-out-shapes", "coarse-vibrations")]
        assert "where bar vibrates, f9 by up to" in said.text
        assert "in more pieces" in said.text
        assert said.doubt


SWING = """[joints]
hub = { type = "spherical", bodies = ["bar", "ground"], point = "root" }
[loads]
weight = { type = "gravity", acceleration = [0.0, 2.0, -9.81] }
pull = { type = "point-force", body = "bar", point = "tip", force = [0.0, 1.3, 0.5], frame = "body" }
wind = { type = "pressure", body = "bar", surface = "top", pressure = 40.0, curve = { type = "polynomial", coefficients = [1.0, 30.0] } }
[design]
p = "loads.wind.pressure"
gust = "loads.wind.curve.coefficients.1"
ratio = "bodies.bar.poisson_ratio"
E = "bodies.bar.youngs_modulus"
taper = "bodies.bar.taper"
omega = "bodies.bar.angular_velocity.z"
[responses]
y = { type = "acceleration", body = "bar", point = "tip", component = "y" }
stress = { type = "ks-stress", body = "bar", aggregation = 10.0, reference_stress = 1e6 }
strain = { type = "strain-energy", body = "bar" }
[solver]
end_time = 0.004
step = 0.002
rho_inf = 0.8
"""


def test_gradients_of_a_solid_that_swings_are_complex_steps(folder):
    """By Poisson's ratio, the modulus, the shape, which turns the chords, and the start; direct, adjoint and complex step."""
    scene = bar_scene(folder, "frames = 2, angular_velocity = [0.3, 0.5, 1.5]", SWING)
    agree(ffrf.compile(scene, variables=["p", "gust", "ratio", "E", "taper", "omega"]), "simulate")


def test_gradients_are_those_of_models_that_are_built_anew(folder, tmp_path):
    """What the file tells of Poisson's ratio and the shape, against central differences of models at other values: of the pieces, and of
    the body in one frame."""
    rest = (
        pulled(0.5 * STIFFNESS, 0.4 * STIFFNESS)
        + 'wind = { type = "pressure", body = "bar", surface = "top", pressure = 2e3 }\n'
        + f"[responses]\n{WHERE}"
        + 'stress = { type = "ks-stress", body = "bar", aggregation = 1e-5 }\n'
        + 'place = { type = "distance", bodies = ["bar", "bar"], points = ["tip", "root"], component = "y" }\n'
    )
    design = '[design]\npoisson_ratio = "bodies.bar.poisson_ratio"\ntaper = "bodies.bar.taper"\n'
    held = [f'frame = "grounded", frames = {frames}' for frames in (1, 4)]
    variables = ["poisson_ratio", "taper"]
    exact = [ffrf.compile(bar_scene(folder, each, rest + design), variables=variables).statics(gradients=True) for each in held]
    for name, value in (("poisson_ratio", 0.3), ("taper", 0.0)):
        ends = []
        for sign in (1, -1):
            save(build(folder / "bar.toml", values={name: value + sign * STEP}), tmp_path / "bar.h5")
            ends.append([ffrf.compile(bar_scene(tmp_path, each, rest)).statics().values for each in held])
        for found, after, before in zip(exact, *ends, strict=True):
            for response, slopes in found.gradients.items():
                difference = (after[response] - before[response]) / (2 * STEP)
                size = max(
                    abs(found.values[response]), 1e-4
                )  # x of one frame is 0; statics end at 1e-10, and the step squared is 1e-6
                assert slopes[name] == pytest.approx(difference, rel=1e-4, abs=1e-6 * size), (response, name)


STEP = 1e-3
FREE = """[loads]
pull = { type = "point-force", body = "bar", point = "tip", force = [0.0, 30.0, 15.0], curve = PULSE }
turn = { type = "torque", body = "bar", point = "root", torque = [1.0, 1.0, 1.0], curve = PULSE }
[solver]
end_time = 0.15
step = 0.002
rho_inf = 0.95
formulation = "ggl"
""".replace("PULSE", '{ type = "table", times = [0.0, 0.05, 0.1], values = [0.0, 1.0, 0.0] }')


def test_a_bent_solid_that_flies_freely_keeps_energy_and_momenta(tmp_path):
    """As a beam does: what they change by is the scheme's, of second order in the step."""
    save_bar(tmp_path, 2, young=2e7)
    changes = changes_in_flight(ffrf.compile(bar_scene(tmp_path, "frames = 2, angular_velocity = [0.3, 0.5, 1.5]", FREE)))
    assert max(changes[1]) < 0.02
    assert all(coarse > 3.3 * fine for coarse, fine in zip(*changes, strict=True))


def test_a_blade_of_solid_elements_that_spins_stiffens(tmp_path):
    """Four pieces give the published flap frequency of a beam to 1 %, as four frames of beams do."""
    save_bar(tmp_path, 4, cells=(8, 1, 1), lengths=(1.0, 0.03, 0.01), ratio=0.0)
    unit = np.sqrt(YOUNG * 0.01**2 / 12 / 1000)
    turns = f'{{ type = "polynomial", coefficients = [0.0, {5 * unit}] }}'
    text = SPUN.replace("TURNS", turns).replace("AXIS", ", axis = [0.0, 0.0, 1.0]").replace('"beam"', '"bar"')
    run = ffrf.compile(bar_scene(tmp_path, "frames = 4", text)).statics()
    assert run.values["first"] * 2 * np.pi / unit == pytest.approx(FLAP, rel=0.01)


@pytest.fixture(scope="module")
def bar(folder):
    """A clamped bar with two frames of two pieces each, under a force."""
    return bar_scene(folder, 'frame = "grounded", frames = 2', pulled(0.5 * STIFFNESS) + f"[responses]\n{WHERE}")


def test_to_the_scene_it_stays_one_body(bar):
    cut = resolve(bar)
    assert list(cut.all_bodies()) == ["ground", "bar", "bar[1]", "bar[2]"]
    assert list(cut.joints) == ["bar at node 2", "bar at node 0"]
    assert cut.written == bar


def test_parts_of_several_pieces_are_reduced_without_loss_under_forces_at_points(folder, bar):
    """The coordinates between are those at rest, whatever the number of modes."""
    rest = pulled(0.5 * STIFFNESS) + f"[responses]\n{WHERE}"
    few = ffrf.compile(bar_scene(folder, 'frame = "grounded", frames = 2, modes_per_frame = 0', rest)).statics()
    for name, value in ffrf.compile(bar).statics().values.items():
        assert few.values[name] == pytest.approx(value, rel=1e-8, abs=1e-9)  # statics end at 1e-10 of the size


def test_pictures_show_one_surface_without_steps(folder, bar):
    """Faces of elements at the cut keep their size where parts meet, one clamp is drawn, and stress is told everywhere."""
    solution = solve_statics(compile_scene(bar))
    moment = SpatialConfiguration(solution, 0)
    shape, surface = body_shape(moment, "bar"), load(folder / "bar.h5").surface
    assert surface is not None
    corners = [points[surface.triangles] for points in (shape.points, surface.position[:, :, 0])]
    areas = [np.linalg.norm(np.cross(each[:, 1] - each[:, 0], each[:, 2] - each[:, 0]), axis=1) for each in corners]
    np.testing.assert_allclose(areas[0], areas[1], rtol=0.1)  # the strain of bending, and how far the face at the cut parts
    assert np.all(np.isfinite(shape.stress))
    assert [symbol.kind for symbol in spatial_symbols(moment)] == ["weld", "pin"]  # the clamp, and the tip
    at_tip = shape.points[surface.position[:, 0, 0] == 1.0].mean(axis=0)
    np.testing.assert_allclose(moment.position("bar", "tip"), at_tip, atol=1e-3)  # a mean of nodes and one of the face


def test_pieces_are_the_same_in_other_units(folder):
    """The energy of a displacement, which mixes lengths and angles, of a piece and of the body, and a point of the surface."""
    model = load(folder / "bar.h5")
    other = converted_model(model, "mm-t-s")
    u = np.tile([1.0, 2.0, 3.0, 0.1, 0.2, 0.3], 4) * np.repeat([1.0, -0.5, 0.3, 0.8], 6)
    v = u * np.tile([1e3] * 3 + [1.0] * 3, 4)
    assert v @ other.invariants.stiffness @ v == pytest.approx(1e3 * (u @ model.invariants.stiffness @ u), rel=1e-12)  # J in N mm
    for one, its in zip(model.elements.stiffness, other.elements.stiffness, strict=True):
        assert v[:12] @ its @ v[:12] == pytest.approx(1e3 * (u[:12] @ one @ u[:12]), rel=1e-12)
    pressed = [each.piece_loads["top"].moment @ np.append(1.0, state[:12]) for each, state in ((model, u), (other, v))]
    np.testing.assert_allclose(pressed[1], 1e9 * pressed[0], rtol=1e-12, atol=1e-9)
    moved = [each.pieces.position @ np.append(1.0, state[:12]) for each, state in ((model, u), (other, v))]
    np.testing.assert_allclose(moved[1], 1e3 * moved[0], rtol=1e-12, atol=1e-9)


def test_what_makes_the_numbers_doubtful_is_said(folder, tmp_path):
    """Short pieces with rigid faces, and pieces that bend far inside, which one frame to each does not show."""
    save_bar(tmp_path, 4, faces="rigid", lengths=(0.1, 0.05, 0.04))
    held, rest = 'frame = "grounded", frames = 4', f"[responses]\n{WHERE}"
    short = ffrf.compile(bar_scene(tmp_path, held, pulled(1.0) + rest)).statics()
    (said,) = [each.text for each in short.verdict.warnings if each.code == "faces-of-pieces"]
    assert "change displacements by -16 to -3.5 %" in said  # rigid faces keep it from contracting across
    torque = [0.0, -5.5 * STIFFNESS, 0.0]
    load = f'[loads]\nroll = {{ type = "torque", body = "bar", point = "tip", torque = {torque} }}\n'
    rolled = ffrf.compile(bar_scene(folder, held, load + rest)).statics()
    (said,) = [each.text for each in rolled.verdict.warnings if each.code == "bent-pieces"]
    turn = float(said.partition("by up to ")[2].partition(" rad")[0])
    assert turn == pytest.approx(5.5 / 4 / 2, rel=0.1)  # of 5.5 rad in all
    away = np.hypot(rolled.values["x"], rolled.values["z"])
    needed = 5.5 / np.sqrt(24 * LIMIT * away)  # n pieces of an arc of 1 m shorten by 5.5^2 / (24 n^2)
    assert f"cut it into some {int(np.ceil(needed))} pieces" in said
    assert not short.verdict.trusted
    assert not rolled.verdict.trusted


def test_pieces_that_are_twisted_and_pulled_do_not_bow(folder):
    load = """[loads]
twist = { type = "torque", body = "bar", point = "tip", torque = [100.0, 0.0, 0.0] }
pull = { type = "point-force", body = "bar", point = "tip", force = [2e4, 0.0, 0.0] }
"""
    run = ffrf.compile(bar_scene(folder, 'frame = "grounded", frames = 4', load + TURN)).statics()
    assert run.values["turn"] > 0.2
    assert shortening(run.solution, "bar")[:2] == pytest.approx((0.0, 0.0), abs=1e-6)  # statics end at 1e-10


TURN = '[responses]\nturn = { type = "rotation", body = "bar", point = "tip", axis = [1.0, 0.0, 0.0] }\n'


def test_points_of_a_face_are_told_by_the_piece_nearer_to_the_clamp(folder):
    model = load(folder / "bar.h5")
    assert model.surface is not None
    assert model.pieces is not None
    behind = np.ceil(4 * model.surface.position[:, 0, 0] - 1e-9)  # round-off of a place
    np.testing.assert_array_equal(model.pieces.element, np.maximum(behind, 1) - 1)


def test_a_solid_that_is_not_in_pieces_says_how_it_would_be(tmp_path):
    save_bar(tmp_path, 0)
    with pytest.raises(
        InputError, match=r"A solid in space is cut into groups of elements: name groups of its mesh in \[pieces\] of"
    ):
        compile_scene(bar_scene(tmp_path, "frames = 2", ""))


def test_more_frames_than_pieces_are_refused(folder):
    with pytest.raises(InputError, match=r"has 4 pieces, and a frame needs one at least. Write at most 4"):
        compile_scene(bar_scene(folder, "frames = 5", ""))


def test_an_error_that_no_number_of_pieces_reaches_is_refused(folder):
    force = pulled(2 * STIFFNESS)
    scene = bar_scene(folder, 'frame = "grounded", frames = "auto", geometric_error = 1e-4', force)
    with pytest.raises(InputError, match=r"One to every piece, 4 in all, .* because the pieces themselves .* some \d+ pieces,"):
        ffrf.compile(scene).statics()


def test_a_file_whose_pieces_disagree_is_refused(folder, tmp_path):
    model = load(folder / "bar.h5")
    assert model.pieces is not None
    assert model.elements is not None
    pieces, elements = model.pieces, model.elements
    fewer = replace(elements, stress_operator=elements.stress_operator[1:])
    for changes, message in (
        ({"pieces": replace(pieces, element=pieces.element + 4)}, "pieces/element holds numbers of elements that"),
        ({"pieces": Pieces(pieces.element[1:], pieces.position[1:])}, "pieces/element tells .* points of"),
        ({"elements": fewer, "element_derivatives": {}, "element_affine": {}}, "elements/stress_operator has .* rows instead of"),
        ({"face_errors": {"least": 0.0}}, 'face_errors lacks "least", "largest" or'),
    ):
        with pytest.raises(ModelFileError, match=message):
            save(replace(model, **changes), tmp_path / "bar.h5")
