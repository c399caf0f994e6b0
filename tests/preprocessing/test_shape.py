"""Shape parameters: dX/dx of a mesh made once, against fresh preprocessing, closed forms and scaling laws; wrong shapes refused."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipe, ellipk

from preprocessing.airfoil.airfoil_file import read_airfoil
from preprocessing.airfoil.contour import Bump, Contour, bumped
from preprocessing.builders.skin_file import SkinFile
from preprocessing.builders.skin_geometry import Geometry, read_geometry, shape_parameters
from preprocessing.builders.skin_recipe import SkinRecipe
from preprocessing.elements.beams import PlanarBeam
from preprocessing.reduction.assembly import interface_point
from preprocessing.reduction.chosen_basis import undeformed
from toolkit.foundation.errors import InputError

MORPHING = Path(__file__).parents[2] / "models" / "morphing_wing"
STEP = 1e-20  # of the complex step, in parts of the parameter: no difference is formed, nothing cancels
AREA = 256 / 315  # integral of (1 - q^2)^4 over [-1, 1]

EXAMPLE = (MORPHING / "skin.toml").read_text().split("[interface_points]")[0]
MODES = """
[interface_points]
at_node = {{ node = 10 }}
at_arc_length = {{ arc_length = 201.234 }}
at_x = {{ x = 61.3, side = "lower" }}
at_end = {{ x = 137.5, side = "lower" }}

[shape.crest]
x = 70.0
side = "upper"
half_width = 50.0
height = {crest!r}

[shape.nose]
arc_length = 148.0
half_width = 40.0
height = {nose!r}
of = "both"

[shape.belly]
x = 60.0
side = "lower"
half_width = 45.0
height = {belly!r}

[shape.wanted]
x = 60.0
side = "lower"
half_width = 45.0
height = {wanted!r}
of = "target"
"""
PLAIN = {"chord": 550.0, "y_scale": 1.0, "crest": 0.0, "nose": 0.0, "belly": 0.0, "wanted": 0.0}
DEFORMED = {"chord": 550.0, "y_scale": 1.05, "crest": 1.3, "nose": -0.7, "belly": 0.4, "wanted": 0.8}
STEPS = {"chord": 0.6, "y_scale": 2e-3, "crest": 0.02, "nose": 0.02, "belly": 0.02, "wanted": 0.02}
"""Of the difference quotients: so small that few nodes pass rows of the file, where the third derivative of the spline jumps."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("shape")
    for name in ("high_speed.dat", "low_speed.dat"):
        shutil.copy(MORPHING / name, folder)
    return folder


@pytest.fixture(scope="module")
def high() -> Contour:
    return Contour.through(read_airfoil(MORPHING / "high_speed.dat").points, 550.0)


def toml(design: dict[str, float]) -> str:
    """skin.toml at a design."""
    scale = f"chord = {design['chord']!r}\ny_scale = {design['y_scale']!r}"
    return EXAMPLE.replace("chord = 550.0", scale) + MODES.format(**design)


def read(folder: Path, text: str) -> tuple[SkinFile, Geometry]:
    path = folder / "skin.toml"
    path.write_text(text)
    file = SkinRecipe.read(path).file
    return file, read_geometry(path, file)


def beams(geometry: Geometry) -> PlanarBeam:
    return PlanarBeam(geometry.mesh.nodes, geometry.mesh.connectivity, [])


def quantities(file: SkinFile, geometry: Geometry) -> dict[str, np.ndarray]:
    """All that preprocessing makes of a geometry: nodes, arc lengths, target, and the interface points in each way to write them."""
    found = {"nodes": geometry.mesh.nodes, "arc_lengths": geometry.arc_lengths, "target": geometry.target}
    z = np.column_stack([undeformed(geometry.mesh.nodes), np.eye(3 * len(geometry.mesh.nodes))])
    for name, place in file.interface_points.items():
        s = geometry.skin.locate(**place.model_dump(), stations=geometry.arc_lengths)
        point = interface_point(beams(geometry), geometry.arc_lengths, z, s)
        found |= {f"s {name}": np.asarray(s), f"position {name}": point.position, f"rotation {name}": point.rotation}
    return found


def by_complex_step(file: SkinFile, geometry: Geometry, name: str, step: float = STEP) -> dict[str, np.ndarray]:
    value = shape_parameters(file)[name]
    moved = geometry.moved({name: value + 1j * step})
    return {key: np.imag(value) / step for key, value in quantities(file, moved).items()}


def by_differences(folder: Path, design: dict[str, float], name: str) -> dict[str, np.ndarray]:
    """Central differences of fresh preprocessing, extrapolated once to the order h^4."""
    quotients = []
    for h in (STEPS[name], STEPS[name] / 2):
        up, down = (quantities(*read(folder, toml({**design, name: design[name] + change}))) for change in (h, -h))
        quotients.append({key: (up[key] - down[key]) / (2 * h) for key in up})
    return {key: (4 * quotients[1][key] - quotients[0][key]) / 3 for key in quotients[0]}


# --- derivatives against fresh preprocessing -------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "design"), [*((name, DEFORMED) for name in STEPS), ("chord", PLAIN), ("nose", PLAIN)])
def test_moved_mesh_has_the_derivatives_of_fresh_preprocessing(name, design, folder):
    file, geometry = read(folder, toml(design))
    exact, reference = by_complex_step(file, geometry, name), by_differences(folder, design, name)
    noise = 1e-14 * geometry.skin.contour.length / STEPS[name]  # of F and G, found by the bisection of fresh preprocessing
    for key, rate in reference.items():
        np.testing.assert_allclose(exact[key], rate, rtol=0, atol=noise + 1e-9 * np.abs(rate).max(), err_msg=key)


def test_complex_step_is_exact_whatever_its_size(folder):
    file, geometry = read(folder, toml(DEFORMED))
    small, large = (by_complex_step(file, geometry, "chord", step) for step in (1e-30, 1e-9))
    for key, rate in small.items():
        scale = np.abs(rate).max()
        # Round-off of lengths up to 1200 mm in eight Newton iterations; a step of 1e-9 has an error of h^2.
        np.testing.assert_allclose(large[key], rate, rtol=0, atol=1e-12 * max(scale, 1.0), err_msg=key)


@pytest.mark.parametrize("values", [{"chord": 560.0}, {"y_scale": 0.9, "crest": -2.0}, {"nose": 1.5, "wanted": 0.0}])
def test_moved_mesh_is_that_of_fresh_preprocessing(values, folder):
    file, geometry = read(folder, toml(DEFORMED))
    moved = quantities(file, geometry.moved(values))
    fresh = quantities(*read(folder, toml({**DEFORMED, **values})))
    for key, value in fresh.items():
        np.testing.assert_allclose(moved[key], value, rtol=0, atol=1e-11, err_msg=key)  # roots to 1e-14 of 1160 mm


def test_nothing_moves_at_the_nominal_design(folder):
    _, geometry = read(folder, toml(DEFORMED))
    moved = geometry.moved({})
    np.testing.assert_array_equal(moved.mesh.nodes, geometry.mesh.nodes)
    np.testing.assert_array_equal(moved.target, geometry.target)
    assert moved.mesh.connectivity is geometry.mesh.connectivity


def test_modes_without_height_leave_the_nodes(folder):
    _, with_modes = read(folder, toml(PLAIN))
    _, without = read(folder, EXAMPLE)
    np.testing.assert_array_equal(with_modes.mesh.nodes, without.mesh.nodes)
    np.testing.assert_array_equal(with_modes.target, without.target)


@pytest.mark.parametrize("name", ["chord", "y_scale", "nose"])
def test_real_part_under_a_complex_step_is_the_nominal_geometry(name, folder):
    file, geometry = read(folder, toml(PLAIN))
    stepped = quantities(file, geometry.moved({name: PLAIN[name] + 1j * STEP}))
    for key, value in quantities(file, geometry).items():
        np.testing.assert_allclose(stepped[key].real, value, rtol=0, atol=1e-11, err_msg=key)  # roots to 1e-14 of 1160 mm


# --- laws and closed forms -------------------------------------------------------------------------------------------


def test_nodes_and_their_derivatives_scale_with_all_lengths(folder):
    """X is homogeneous of degree 1 in all lengths, so dX/dchord and dX/dheight are of degree 0 and dX/dy_scale of degree 1."""

    def scaled(found: re.Match) -> str:
        return f"{found[1]} = {2 * float(found[2])!r}"

    small_text = toml({**PLAIN, "y_scale": 1.05, "nose": -0.7})
    large_text = re.sub(r"\b(chord|x|arc_length|half_width|height) = (-?[\d.]+)", scaled, small_text)
    small, large = read(folder, small_text), read(folder, large_text)
    for name, degree in {"chord": 0, "y_scale": 1, "nose": 0}.items():
        rates, rates_of_large = by_complex_step(*small, name), by_complex_step(*large, name)
        for key in ("nodes", "arc_lengths", "target"):
            expected = 2**degree * rates[key]
            # Of degree 1/length in a root that is known to 1e-14 of the contour.
            np.testing.assert_allclose(rates_of_large[key], expected, rtol=0, atol=1e-11 * max(np.abs(expected).max(), 1.0))
    np.testing.assert_allclose(large[1].mesh.nodes, 2 * small[1].mesh.nodes, rtol=0, atol=2e-11)  # the root, as above


def circle(n: int = 400) -> Contour:
    """Circle of radius 1 round (1, 0), from its tail (2, 0) anticlockwise; a quintic of 400 rows, exact to 1e-11."""
    angle = np.linspace(0, 2 * np.pi, n + 1)
    return Contour.through(0.5 + 0.5 * np.column_stack([np.cos(angle), np.sin(angle)]) - [0, 0.5], 2.0, degree=5)


def test_y_scale_makes_an_ellipse_of_a_circle_with_the_derivative_of_its_length():
    b = 0.3
    length = circle().stretched(1.0, b + 1j * STEP).length
    m = 1 - b**2  # perimeter 4 E(m) of half axes 1 and b, dE/dm = (E - K) / (2 m), dm/db = -2 b
    assert length.real == pytest.approx(4 * ellipe(m), rel=1e-9)  # the rows; measured 1e-11
    assert length.imag / STEP == pytest.approx(4 * b * (ellipk(m) - ellipe(m)) / m, rel=1e-9)


def test_bump_on_a_circle_lengthens_it_by_its_curvature():
    """dL/dh = integral of curvature times b ds = half_width AREA for radius 1."""
    length = bumped(circle(), [Bump(np.pi, 0.4, 1j * STEP)]).length
    assert length.imag / STEP == pytest.approx(0.4 * AREA, rel=1e-8)  # curvature of the quintic: fourth order, measured 1e-9


@pytest.mark.parametrize("place", [300.0, 564.0, 820.0], ids=["upper", "nose", "lower"])
@pytest.mark.parametrize("height", [2.0, -1.0])
def test_bump_moves_its_centre_by_its_height_outward_and_nothing_outside(place, height, high):
    with_bump = bumped(high, [Bump(place, 30.0, height)])
    angle = high.tangent_angle(place)
    outward = np.array([np.sin(angle), -np.cos(angle)])
    u = high.curve.parameter(np.array([place, place - 30.0, place + 30.0, 50.0, 1000.0]))
    shift = with_bump.curve.spline(u) - high.curve.spline(u)
    np.testing.assert_allclose(shift[0], height * outward, rtol=0, atol=1e-12)  # round-off of 550 mm
    assert np.all(shift[3:] == 0)
    np.testing.assert_allclose(shift[1:3], 0, atol=1e-12)  # round-off
    assert (np.cross([*outward, 0], [*(high.curve.direction(place)), 0])[2]) == pytest.approx(1.0)  # outward: right of the travel


def test_bumps_add_up(high):
    one, two = Bump(540.0, 30.0, 1.0), Bump(560.0, 30.0, -0.4)
    u = high.curve.parameter(np.linspace(500.0, 600.0, 50))
    base = high.curve.spline(u)
    apart = sum(bumped(high, [bump]).curve.spline(u) - base for bump in (one, two))
    np.testing.assert_allclose(bumped(high, [one, two]).curve.spline(u) - base, apart, rtol=0, atol=1e-12)  # round-off


@pytest.mark.parametrize("order", [0, 1])
def test_derivatives_of_a_bumped_curve_agree_with_a_complex_step_of_its_parameter(order, high):
    curve = bumped(high, [Bump(564.0, 30.0, 1.5), Bump(540.0, 40.0, -0.5)]).curve.spline
    u = high.curve.parameter(np.linspace(495.0, 600.0, 301))
    by_step = np.imag(curve(u + 1j * STEP, order)) / STEP
    np.testing.assert_allclose(by_step, curve(u, order + 1), rtol=0, atol=1e-12)  # round-off


def test_arc_length_of_a_bumped_curve_is_true(high):
    contour = bumped(high, [Bump(564.0, 7.0, 1.5)])  # narrow: its ends lie between rows
    steps = np.diff(contour.position(np.linspace(540.0, 590.0, 20001)), axis=0)
    # Polygon of steps h = 0.0025 on curvatures up to 1 / mm: short by (kappa h)^2 / 24 = 3e-7.
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), 50.0 / 20000, rtol=1e-6)


def test_tangent_angle_and_curvature_carry_a_complex_step():
    """An ellipse of half axes 1 and b at its lower end: angle 2 pi, curvature b; at 45 degrees tan(angle) = -b."""
    b = 0.5
    contour = circle().stretched(1.0, b + 1j * STEP)
    corner = circle().curve.parameter(np.pi / 4)
    angle = contour.tangent_angle(contour.curve.arc_length(corner))
    assert angle.real == pytest.approx(np.pi - np.arctan(b), rel=1e-8)  # rows, slope of the quintic
    assert angle.imag / STEP == pytest.approx(-1 / (1 + b**2), rel=1e-8)
    lowest = contour.curve.arc_length(circle().curve.parameter(1.5 * np.pi))
    assert contour.curvature(lowest).imag / STEP == pytest.approx(1.0, rel=1e-6)  # curvature of the quintic: fourth order


# --- which contour a mode deforms ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "airfoil", "target"), [("crest", True, True), ("nose", True, True), ("wanted", False, True)])
def test_mode_moves_what_it_is_of(name, airfoil, target, folder):
    rates = by_complex_step(*read(folder, toml(PLAIN)), name)
    assert np.any(rates["nodes"]) == airfoil
    # A bump of the airfoil alone lengthens the skin, so that its nodes slide along the target.
    assert np.any(rates["target"]) == target


def test_bump_of_the_airfoil_alone_slides_the_target_points_along_the_target(folder):
    file, geometry = read(folder, toml(PLAIN))
    rates = by_complex_step(file, geometry, "crest")
    start = geometry.target_contour.nearest(geometry.mesh.nodes[0])
    along = geometry.target_contour.curve.direction(start + geometry.arc_lengths)
    expected = rates["arc_lengths"][:, None] * along
    np.testing.assert_allclose(rates["target"], expected, rtol=0, atol=1e-11)  # round-off through the root at F


def test_chord_leaves_files_that_hold_lengths(folder):
    for name in ("high_speed", "low_speed"):
        rows = read_airfoil(MORPHING / f"{name}.dat").points * 550.0
        np.savetxt(folder / f"{name}_mm.dat", rows, fmt="%.9f", header=name, comments="")
    text = toml(PLAIN).replace("_speed.dat", "_speed_mm.dat").replace("chord = 550.0", 'chord = 550.0\nunits = "mm"')
    file, geometry = read(folder, text)
    assert list(shape_parameters(file)) == ["y_scale", "crest", "nose", "belly", "wanted"]
    with pytest.raises(
        InputError, match=r"'chord' is no shape parameter of .*; the airfoil files are in mm, and no chord scales them"
    ):
        geometry.moved({"chord": 551.0})


def test_nominal_values_are_those_of_the_file(folder):
    file, _ = read(folder, toml(DEFORMED))
    assert shape_parameters(file) == DEFORMED


# --- what cannot be differentiated -----------------------------------------------------------------------------------


def test_curvature_spacing_moves_but_is_not_differentiated_by_the_airfoil(folder):
    file, geometry = read(folder, toml(PLAIN).replace('spacing = "equal"', 'spacing = "curvature"'))
    assert np.isrealobj(geometry.moved({"chord": 551.0}).mesh.nodes)
    with pytest.raises(InputError, match=r'skin\.toml\', skin: nodes spaced by "curvature" have no derivative by the shape'):
        geometry.moved({"chord": 550.0 + 1e-20j})
    rates = by_complex_step(file, geometry, "wanted")  # the target may: no node of the skin depends on it
    assert np.any(rates["target"])
    assert not np.any(rates["nodes"])


def test_point_that_passes_a_node_is_refused_with_the_remedy(folder):
    _, geometry = read(folder, toml(PLAIN))
    moved = geometry.moved({"chord": 550.0 + 1e-20j})
    z = np.eye(3 * len(moved.mesh.nodes))
    with pytest.raises(InputError, match=r"is that of node 10, but .* it has no derivative\. Write node = 10"):
        interface_point(beams(moved), moved.arc_lengths, z, geometry.arc_lengths[10])
    at_node = interface_point(beams(moved), moved.arc_lengths, z, moved.skin.locate(node=10, stations=moved.arc_lengths))
    assert at_node.arc_length == moved.arc_lengths[10]


def test_place_by_its_x_at_the_upright_nose_has_no_derivative(high):
    nose = high.position(high.leading_edge)[0]
    x = float(nose) + 1e-9
    side = next(side for side in ("upper", "lower") if _is_on(high, x, side))
    with pytest.raises(InputError, match=rf"the {side} side is upright at x = .* Name the point by its arc length"):
        high.stretched(1.0, 1.0 + 1j * STEP).at_x(x, side)


def _is_on(contour: Contour, x: float, side: str) -> bool:
    try:
        contour.at_x(x, side)
    except InputError:
        return False
    return True


# --- wrong input -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("values", "message"), [
    ({"crust": 1.0}, "'crust' is no shape parameter of .*; available: chord, y_scale, crest, nose, belly, wanted"),
    ({"chord": -550.0 + 1e-20j}, "the shape parameter 'chord' cannot be .* above 0 for a chord or scale"),
    ({"y_scale": 0.0}, "the shape parameter 'y_scale' cannot be 0.0"),
    ({"nose": float("nan")}, "the shape parameter 'nose' cannot be nan: give a finite number"),
    ({"crest": 1e4 + 1e-20j}, "F|fold|skin|target"),
])  # fmt: skip
def test_impossible_designs_are_refused(values, message, folder):
    _, geometry = read(folder, toml(PLAIN))
    with pytest.raises(InputError, match=message):
        geometry.moved(values)


@pytest.mark.parametrize(("old", "new", "message"), [
    ("half_width = 50.0", "half_width = 900.0",
     r"shape\.crest: the bump would reach from -.* which runs from 0 .* Give a half_width of at most 48.*, or another place"),
    ("half_width = 50.0", "half_width = 1e-6", r"shape\.crest: half_width 1e-06 is less than 1e-06 of the contour's length"),
    ("arc_length = 148.0", "arc_length = 1480.0", r"shape\.nose: the bump would reach .* Give another place"),
    ('x = 70.0\nside = "upper"', 'x = 700.0\nside = "upper"', r"shape\.crest: the upper side does not reach x = 700"),
    ('x = 70.0\nside = "upper"', 'x = 70.0\nside = "top"', r"shape\.crest\.side: input should be 'upper' or 'lower' \(given: 'top'"),
    ('x = 70.0\nside = "upper"', "x = 70.0", r"shape\.crest: give either arc_length, or x with side \(given: x\)"),
    ('x = 70.0\nside = "upper"', "", r"shape\.crest: give either arc_length, or x with side \(given: nothing\)"),
    ("half_width = 50.0", "", r"shape\.crest\.half_width: this key is missing"),
    ("half_width = 50.0", "half_width = -5.0", r"shape\.crest\.half_width: input should be greater than 0"),
    ("half_width = 50.0", "width = 50.0", r"shape\.crest\.width: unknown key, did you mean 'half_width'; possible here: arc_length, x"),
    ("half_width = 40.0\nheight = 0.0", "half_width = 12.0\nheight = -8.0", r"shape modes: .* folds the contour at its arc length"),
    ("half_width = 40.0\nheight = 0.0", "half_width = 4.0\nheight = 8.0", "a bump of half_width 4 cannot have a height of 8"),
    ('of = "both"', 'of = "all"', r"shape\.nose\.of: input should be 'airfoil', 'target' or 'both'"),
    ("y_scale = 1.0", "y_scale = 0.0", r"airfoil\.y_scale: input should be greater than 0"),
    ("[shape.crest]", "[shape.chord]", "a shape mode cannot have the name of another parameter .*; choose another name"),
    ("[shape.crest]", "[shape.poisson_ratio]", "a shape mode cannot have the name of another parameter"),
    ("[shape.crest]", "[shape.thickness_3]", r"a shape mode's name cannot begin like those of element groups \(thickness_, width_"),
    ("[shape.crest]", '[shape."a.b"]', "this is no legal name of a shape mode; use letters, digits and _"),
    ("[shape.crest]", '[shape."a/b"]', "this is no legal name of a shape mode"),
])  # fmt: skip
def test_wrong_modes_are_refused_by_name(old, new, message, folder):
    text = toml(PLAIN)
    assert old in text
    with pytest.raises(InputError, match=message):
        read(folder, text.replace(old, new, 1))


def test_bump_that_takes_f_off_the_target_is_refused_with_the_remedy(folder):
    text = toml(PLAIN).replace("arc_length = 148.0", "arc_length = 5.0").replace('of = "both"', 'of = "airfoil"')
    with pytest.raises(InputError, match=r'the target shape passes F .* give a shape mode at F of = "both"'):
        read(folder, text.replace("half_width = 40.0\nheight = 0.0", "half_width = 40.0\nheight = 2.0"))


@pytest.mark.parametrize("y_scale", [0.05, 0.3, 3.0, 30.0])
@pytest.mark.parametrize("airfoil", ["fx63137.dat", "naca23015.af", "fx62k131.dat"])
def test_arc_length_and_parameter_are_inverse_on_strongly_stretched_contours(airfoil, y_scale):
    points = read_airfoil(Path(__file__).parents[1] / "data" / "airfoils" / airfoil).points
    curve = Contour.through(points, 550.0).stretched(1.0, y_scale).curve
    s = np.linspace(0, curve.length, 3001)
    np.testing.assert_allclose(curve.arc_length(curve.parameter(s)), s, rtol=0, atol=1e-12 * curve.length)  # round-off
