"""Bodies whose frame goes through two interface points: closed forms, what both points may do in it, and derivatives by every design."""

from __future__ import annotations

import shutil
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

from preprocessing import build
from preprocessing.builders.frame_file import frame_elements, frame_space
from preprocessing.builders.frame_recipe import FrameRecipe, polygon_beam
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from preprocessing.reduction.chosen_basis import reduced_basis, undeformed
from preprocessing.reduction.invariants import contract_at
from tests.preprocessing.test_frame_models import FRAME, close, rate
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.dependence import scattered
from toolkit.reduced_model.design_point import DesignPoint, rates_at
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.model import Chord, ReducedModel, chord_of

SECTION = Section(youngs_modulus=2e11, density=7800.0, thickness=0.006, width=0.01)
LENGTH, ENDS = 0.3, ("A", "B")
CHORDS = {
    "full": BasisChoice("full", chord=ENDS),
    "eigenmodes": BasisChoice("eigenmodes", count=6, chord=ENDS),
    "craig-bampton": BasisChoice("craig-bampton", count=4, chord=ENDS),
    "static": BasisChoice("static", chord=ENDS),
}

PLANE = """units = "m-kg-s"
dimension = 2
nodes = { A = [0.1, -0.2], D = [0.5, 0.9] }
beams = [
    { from = "A", to = "B", section = "leg", elements = 3 },
    { from = "B", to = "C", section = "arm", elements = 3 },
    { from = "B", to = "D", section = "arm", elements = 2 },
]
materials = { steel = { youngs_modulus = 2.1e11, density = 7850.0 } }
damping = { mass = 0.3, stiffness = 1e-4 }

[polar_nodes]
C = { from = "B", length = 0.5, angle = -0.3 }
B = { from = "A", length = 0.8, angle = 1.2 }

[sections]
leg = { kind = "rectangle", thickness = 0.02, width = 0.04, material = "steel" }
arm = { kind = "rectangle", thickness = 0.01, width = 0.03, material = "steel" }

[interface_points]
foot = { node = "A" }
tip = { node = "C" }
"""
ON_CHORD = 'basis = { kind = "KIND", COUNT chord = ["foot", "tip"] }\n'
IN_SPACE = FRAME.replace('clamp = ["A"]\n', "").replace("[interface_points]", '[interface_points]\nfoot = { node = "A" }')
KINDS = {"full": "", "eigenmodes": "count = 5,", "craig-bampton": "count = 3,", "static": ""}


def with_chord(text: str, kind: str) -> str:
    units, rest = text.split("\n", 1)
    return "\n".join([units, ON_CHORD.replace("KIND", kind).replace("COUNT", KINDS[kind]), rest])


@pytest.fixture(params=["plane", "space"])
def text(request):
    return PLANE if request.param == "plane" else IN_SPACE


def beam(
    angle: float, choice: BasisChoice, middle: float = 0.45 * LENGTH, ends: tuple[float, float] = (0.0, LENGTH)
) -> ReducedModel:
    nodes = np.linspace(0, LENGTH, 17)[:, None] * np.array([[np.cos(angle), np.sin(angle)]])
    return polygon_beam(nodes, SECTION, {"A": ends[0], "M": middle, "B": ends[1]}, basis=choice)


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2])
@pytest.mark.parametrize("kind", CHORDS)
def test_frequencies_are_those_of_a_beam_on_two_pins(kind, angle):
    """(k pi / L)^2 sqrt(E I / rho A); the first frequency of shapes that are static alone is known to a percent."""
    inv = beam(angle, CHORDS[kind]).invariants
    found = np.sqrt(eigh(inv.stiffness, inv.inertia[1:, 1:], eigvals_only=True)[0])
    expected = (np.pi / LENGTH) ** 2 * np.sqrt(2e11 * 0.006**2 / 12 / 7800)
    np.testing.assert_allclose(found, expected, rtol=1e-2 if kind == "static" else 2e-4)  # 16 elements: (pi / 16)^4 / 720 = 2e-6


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_point_stays_and_the_second_moves_along_the_chord(text, kind, tmp_path):
    """In space the first one does not turn about the chord, either; and the file says all that after it was read back."""
    (tmp_path / "frame.toml").write_text(with_chord(text, kind))
    save(build(tmp_path / "frame.toml"), tmp_path / "frame.h5")
    model = load(tmp_path / "frame.h5")
    assert chord_of(model.reference_condition) == Chord("foot", "tip")
    (one, turned), (other, _) = (model.interfaces[name].here for name in ("foot", "tip"))
    e = other[:, 0] - one[:, 0]
    e = e / np.linalg.norm(e)
    moved = other[:, 1:]
    size = np.abs(moved).max()
    assert np.abs(one[:, 1:]).max() == 0  # whatever round-off the shapes have
    assert np.abs(moved - np.outer(e, e @ moved)).max() < 1e-9 * size  # that of the eigenvalue problem
    assert np.abs(e @ moved).max() > 0.1 * size
    if model.dimension == 3:
        assert np.abs(e @ turned[:, 1:]).max() < 1e-9 * np.abs(turned[:, 1:]).max()


def test_a_static_basis_carries_loads_at_its_points_as_all_coordinates_do(text, tmp_path):
    """Motions of all named points under couples at the ends, whichever basis: constraint modes are exact."""
    moved = {}
    for kind in ("full", "static", "craig-bampton"):
        (tmp_path / "frame.toml").write_text(with_chord(text, kind))
        model = build(tmp_path / "frame.toml")
        rows = [np.atleast_2d(each)[:, 1:] for name in ("foot", "tip") for each in model.interfaces[name].here]
        rows = np.vstack([np.squeeze(each) for each in rows])
        load = rows.T @ np.random.default_rng(1).normal(size=len(rows))
        moved[kind] = rows @ np.linalg.solve(model.invariants.stiffness, load)
    close(moved["static"], moved["full"], 1e-8)  # condition of the full stiffness, 1e7
    close(moved["craig-bampton"], moved["full"], 1e-8)


# derivatives


def test_polynomials_of_a_full_basis_are_a_fresh_preprocessing_at_any_design(text, tmp_path):
    """A chord keeps its coordinates as long as its points stay where they are."""
    (tmp_path / "frame.toml").write_text(with_chord(text, "full"))
    model, space = build(tmp_path / "frame.toml"), frame_space(FrameRecipe.read(tmp_path / "frame.toml").file)
    other = {
        name: value * (1.1 + 0.02 * k) for k, (name, value) in enumerate(model.nominal.items()) if name in space.in_monomials
    }
    assert len(other) > 5
    fresh, p = build(tmp_path / "frame.toml", values=other), np.array(list({**model.nominal, **other}.values()))
    for name in (field.name for field in fields(model.invariants)):
        expected = getattr(fresh.invariants, name)
        close(model.affine[name](p, expected.size).reshape(expected.shape), expected, 1e-12)


PARAMETERS = {
    "plane": ["length_B", "angle_C", "x_A", "y_D", "thickness_arm", "youngs_modulus_steel"],
    "space": ["x_A", "z_D", "y_C", "poisson_ratio_alloy", "wall_leg"],
}


@pytest.mark.parametrize("where", PARAMETERS)
@pytest.mark.parametrize("kind", ["full", "static", "craig-bampton"])
def test_all_derivatives_are_the_complex_step(where, kind, tmp_path):
    """By the ends of the chord, whose line turns with them, by the nodes between, lengths, angles, and what beams are made of.

    Of shapes that are computed, the span is differentiated: what is compared is the compliance between the named points, and their places.
    """
    path = tmp_path / "frame.toml"
    path.write_text(with_chord(PLANE if where == "plane" else IN_SPACE, kind))
    model, file = build(path), FrameRecipe.read(path).file
    for parameter in PARAMETERS[where]:
        exact, size = _complex_step(file, model, parameter), abs(model.nominal[parameter])
        if kind == "full":
            points = [f"interfaces.{name}.{item}" for name in ("foot", "tip") for item in ("position", "rotation")]
            for item in [*(field.name for field in fields(model.invariants)), *points]:
                alike(size * rate(model, item, parameter), size * exact[item], model.item(item), 1e-10)
        found, compliance = _compliance(model, parameter)
        alike(size * found, size * exact["compliance"], compliance, 1e-8)  # condition of K 1e7


def alike(found: np.ndarray, expected: np.ndarray, value: np.ndarray, tolerance: float) -> None:
    """Changes of a value by a parameter of size one, which may be zero."""
    scale = max(np.abs(expected).max(initial=0), np.abs(value).max(initial=0))
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * scale)


def _rows(model_or_points: Any, dimension: int) -> np.ndarray:
    """Motions of both ends by the elastic coordinates, (2 m, n_f)."""
    found = []
    for name in ("foot", "tip"):
        point = model_or_points[name]
        found += [point.position[0][:, 1:], np.atleast_2d(point.rotation[0])[:, 1:]]
    return np.vstack(found)


def _complex_step(file: Any, model: ReducedModel, parameter: str) -> dict[str, np.ndarray]:
    """Derivatives at the step 1e-30 through elements and a full basis on the chord."""
    elements = frame_elements(file, {**model.nominal, parameter: model.nominal[parameter] + 1e-30j})
    z = _stepped_basis(elements)
    inv = contract_at(elements.parts, {**model.nominal, parameter: model.nominal[parameter] + 1e-30j}, z)
    found = {field.name: np.imag(getattr(inv, field.name)) / 1e-30 for field in fields(inv)}
    points = elements.interfaces(z)
    for name, point in points.items():
        found |= {f"interfaces.{name}.{item}": np.imag(getattr(point, item)) / 1e-30 for item in ("position", "rotation")}
    rows = _rows(points, model.dimension)
    found["compliance"] = np.imag(rows @ np.linalg.solve(inv.stiffness, rows.T)) / 1e-30
    return found


def _stepped_basis(elements: Any) -> np.ndarray:
    """All coordinates that follow the chord's conditions, with the same ones eliminated, from the conditions themselves."""
    xi, rows = undeformed(elements.nodes), elements.interface_rows()
    d, m = elements.nodes.shape[1], 3 * elements.nodes.shape[1] - 3
    n = len(xi)
    real = reduced_basis(
        BasisChoice("full", chord=("foot", "tip")),
        None,
        None,
        np.real(elements.nodes),
        [],
        "",
        {name: np.real(each) for name, each in rows.items()},
    )
    free = np.array([np.flatnonzero(column == 1)[0] for column in _unit_columns(real.z[:, 1:])])
    pinned = np.setdiff1d(np.arange(n), free)
    e = rows["tip"][:d] @ xi - rows["foot"][:d] @ xi
    e = e / np.sqrt(e @ e)
    across = np.eye(d) - np.outer(e, e)  # has the rank d - 1; the rows that are most across make it regular
    keep = np.argsort(np.abs(np.real(e)))[: d - 1]
    conditions = [rows["foot"][:d], *([e[None] @ rows["foot"][3:]] if d == 3 else []), (across @ rows["tip"][:d])[np.sort(keep)]]
    held = np.vstack(conditions)
    assert held.shape == (m, n)
    psi = np.zeros((n, n - m), complex)
    psi[free] = np.eye(n - m)
    psi[pinned] = -np.linalg.solve(held[:, pinned], held[:, free])
    return np.column_stack([xi, psi])


def _unit_columns(psi: np.ndarray) -> np.ndarray:
    """Columns with the entries of coordinates that others follow, or that are one of two, at zero."""
    alone = np.count_nonzero(psi, axis=1) == 1
    return np.where(alone[:, None] & (psi == 1), psi, 0.0).T


def _compliance(model: ReducedModel, parameter: str) -> tuple[np.ndarray, np.ndarray]:
    """R K^-1 R^T of the model's own arrays and derivatives: its rate, and itself."""
    h = 1e-30j
    points = {}
    for name in ("foot", "tip"):
        point = model.interfaces[name]
        position = point.position + h * rate(model, f"interfaces.{name}.position", parameter)
        rotation = point.rotation + h * rate(model, f"interfaces.{name}.rotation", parameter)
        points[name] = type(point)(point.arc_length, point.arc_length_range, position, rotation)
    rows = _rows(points, model.dimension)
    stiffness = model.invariants.stiffness + h * rate(model, "stiffness", parameter)
    found = rows @ np.linalg.solve(stiffness, rows.T)
    return np.imag(found) / 1e-30, np.real(found)


def test_eigenvalues_of_modes_on_a_chord_follow_the_design(tmp_path):
    """Against central differences of the eigenvalues of models built afresh, extrapolated from two steps."""
    path = tmp_path / "frame.toml"
    path.write_text(with_chord(PLANE, "eigenmodes"))
    model = build(path)
    for parameter in ("length_C", "angle_C", "thickness_arm"):

        def eigenvalues(change: float, parameter=parameter) -> np.ndarray:
            value = model.nominal[parameter] * (1 + change)
            return np.diag(build(path, values={parameter: value}).invariants.stiffness)

        steps = [(eigenvalues(h) - eigenvalues(-h)) / (2 * h * model.nominal[parameter]) for h in (4e-3, 2e-3)]
        close(np.diag(rate(model, "stiffness", parameter)), (4 * steps[1] - steps[0]) / 3, 1e-6)  # (4e-3)^4, and round-off


def test_the_chord_follows_the_place_of_its_end_on_a_beam():
    """All coordinates of a beam that is held inside its elements, against beams that are built with the end elsewhere."""
    choice, place, h = CHORDS["full"], 0.8 * LENGTH, 1e-5

    def built(at: float) -> np.ndarray:
        model = beam(0.7, choice, ends=(0.05 * LENGTH, at))
        rotation = model.interfaces["A"].here[1][1:]
        return np.array(rotation @ np.linalg.solve(model.invariants.stiffness, rotation))

    model = beam(0.7, choice, ends=(0.05 * LENGTH, place))
    assert {"arc_length_A", "arc_length_B"} <= set(model.nominal)
    assert "arc_length_M" not in model.nominal  # which all coordinates know at every place
    design = DesignPoint(model)
    slopes = {}
    for item in ("stiffness", "interfaces.A.rotation"):
        shape = model.item(item).shape
        slopes[item] = scattered(*rates_at(design, item, {"arc_length_B": 0}).by(0), int(np.prod(shape))).reshape(shape)
    rotation = model.interfaces["A"].rotation[0] + 1e-30j * slopes["interfaces.A.rotation"][0]
    stiffness = model.invariants.stiffness + 1e-30j * slopes["stiffness"]
    found = np.imag(rotation[1:] @ np.linalg.solve(stiffness, rotation[1:])) / 1e-30
    expected = (8 * (built(place + h) - built(place - h)) - built(place + 2 * h) + built(place - 2 * h)) / (12 * h)
    np.testing.assert_allclose(found, expected, rtol=1e-6)  # round-off of K^-1 over h


# refusals


def test_a_chord_that_cannot_be_had_is_refused_by_key(text, tmp_path):
    good = with_chord(text, "full")
    wrong = {
        ('["foot", "tip"]', '["foot", "top"]'): "basis.chord: there is no interface point 'top'; there are foot, tip",
        ('["foot", "tip"]', '["tip", "tip"]'): "chord goes through two interface points; got tip, tip. Name two different ones",
        ('["foot", "tip"]', '["tip"]'): "basis.chord: list should have at least 2 items",
        (
            'kind = "full",',
            'kind = "eigenmodes", count = 3, boundary = "free",',
        ): 'boundary "free" floats about mean axes, and a chord',
    }
    for (old, new), message in wrong.items():
        (tmp_path / "frame.toml").write_text(good.replace(old, new))
        with pytest.raises(InputError) as caught:
            build(tmp_path / "frame.toml")
        assert message in str(caught.value)
    clamped = good.replace("\n", '\nclamp = ["A"]\n', 1)
    (tmp_path / "frame.toml").write_text(clamped)
    with pytest.raises(InputError, match="a frame has its frame either on a chord or at a clamp"):
        build(tmp_path / "frame.toml")


def test_points_that_tell_no_line_are_refused():
    with pytest.raises(InputError, match="'A' and 'B' are at one place; a chord needs two places"):
        beam(0.3, CHORDS["full"], ends=(0.1, 0.1))
    with pytest.raises(InputError, match="'A' and 'B' are nearest to one node"):
        beam(0.3, CHORDS["full"], ends=(0.1, 0.101))
    with pytest.raises(InputError, match="there is no 'Q'; there are A, M, B"):
        beam(0.3, BasisChoice("full", chord=("A", "Q")))


WING = Path(__file__).parents[2] / "models" / "morphing_wing"


@pytest.mark.parametrize("basis", [{"kind": "full"}, {"kind": "craig-bampton", "count": 4}])
def test_a_skin_on_a_chord_follows_its_thickness_and_its_airfoil(basis, tmp_path):
    """The compliance between all its points, against central differences of fourth order of skins that are built afresh."""
    for name in ("high_speed.dat", "low_speed.dat"):
        shutil.copy(WING / name, tmp_path)
    path = tmp_path / "skin.toml"
    path.write_text((WING / "skin.toml").read_text().replace('clamp = "F"', ""))
    keys = {"basis": {**basis, "chord": ["C", "E"]}}
    model = build(path, keys=keys)
    assert chord_of(model.reference_condition) == Chord("C", "E")

    def compliance(built: ReducedModel) -> np.ndarray:
        rows = np.vstack([point.position[0][:, 1:] for point in built.interfaces.values()])
        return rows @ np.linalg.solve(built.invariants.stiffness, rows.T)

    for parameter in ("thickness", "y_scale"):
        h = 1e-3 * model.nominal[parameter]
        near = {
            k: compliance(build(path, values={parameter: model.nominal[parameter] + k * h}, keys=keys)) for k in (-2, -1, 1, 2)
        }
        expected = (8 * (near[1] - near[-1]) - near[2] + near[-2]) / (12 * h)
        moved = {
            name: point.position + 1e-30j * rate(model, f"interfaces.{name}.position", parameter)
            for name, point in model.interfaces.items()
        }
        rows = np.vstack([position[0][:, 1:] for position in moved.values()])
        stiffness = model.invariants.stiffness + 1e-30j * rate(model, "stiffness", parameter)
        close(
            np.imag(rows @ np.linalg.solve(stiffness, rows.T)) / 1e-30, expected, 1e-7
        )  # round-off of the skin's stiffness over h

    path.write_text((WING / "skin.toml").read_text())
    with pytest.raises(
        InputError, match=r"a skin has its frame either on a chord or at a clamp; leave skin.clamp or the chord out"
    ):
        build(path, keys=keys)
