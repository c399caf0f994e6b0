"""What frozen reduced bases do to numbers away from their design, against closed forms and finite elements of the test's own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy

import ffrf
from preprocessing import build
from tests.models.solid_bodies import rectangle, write_body
from toolkit.analyses.sensitivity.certificate.fresh_models import Fresh, FreshGradients, doubts_of_fresh
from toolkit.analyses.sensitivity.direct import direct
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.frozen_basis import RICHER_PARTS, richer_model, turns

MODULUS, DENSITY, FORCE = 2.0e10, 400.0, 2000.0
ROOT, OUTER, WIDTHS = 10.0, 30.0, (1.5, 1.0)
BODY = """units = "m-kg-s"
dimension = 2
nodes = { A = [0.0, 0.0], M = [10.0, 0.0], B = [40.0, 0.0] }
beams = [
    { from = "A", to = "M", section = "root", elements = 6 },
    { from = "M", to = "B", section = "outer", elements = 18 },
]
sections.root = { kind = "rectangle", thickness = 1.0, width = 1.5, material = "m" }
sections.outer = { kind = "rectangle", thickness = 0.5, width = 1.0, material = "m" }
materials.m = { youngs_modulus = 2.0e10, density = 400.0 }
clamp = ["A"]
interface_points = { tip = { node = "B" } }
basis = { BASIS, derivative = "frozen" }
"""
SCENE = """units = "m-kg-s"
points.T = { body = "blade", interface = "tip" }
bodies.blade = { type = "flexible", model = "blade.h5", frame = "grounded" }
loads.push = { type = "point-force", body = "blade", point = "T", force = [0.0, 2000.0] }
[responses]
ty = { type = "displacement", body = "blade", point = "T", component = "y" }
f1 = { type = "frequency", number = 1 }
f2 = { type = "frequency", number = 2 }
[design]
tr = "bodies.blade.thickness_root"
to = "bodies.blade.thickness_outer"
E = "bodies.blade.youngs_modulus_m"
rho = "bodies.blade.density_m"
[solver]
end_time = 1.0
step = 0.02
"""
OF_MODES, RICH = 'kind = "eigenmodes", count = 2', 'kind = "craig-bampton", count = 12'


def written(folder: Path, basis: str) -> Path:
    (folder / "blade.toml").write_text(BODY.replace("BASIS", basis))
    save(build(folder / "blade.toml"), folder / "blade.h5")
    (folder / "scene.toml").write_text(SCENE)
    return folder / "scene.toml"


@pytest.fixture(scope="module")
def blade(tmp_path_factory) -> Path:
    return written(tmp_path_factory.mktemp("blade"), OF_MODES)


def compiled(scene: Path, variables=("tr", "to")):
    return ffrf.compile(ffrf.read_scene(scene), variables=list(variables))


def deflection(t_root: float, t_outer: float) -> float:
    """Of the tip of a cantilever in two thicknesses, by its curvatures."""
    stiff = [MODULUS * width * t**3 / 12 for width, t in zip(WIDTHS, (t_root, t_outer), strict=True)]
    return FORCE / 3 * (((ROOT + OUTER) ** 3 - OUTER**3) / stiff[0] + OUTER**3 / stiff[1])


def frequencies(t_root: float, t_outer: float) -> np.ndarray:
    """The lowest two in Hz, by beam elements a quarter as long as those of the body."""
    lengths = np.repeat([ROOT / 24, OUTER / 72], [24, 72])
    thickness, width = np.repeat([t_root, t_outer], [24, 72]), np.repeat(WIDTHS, [24, 72])
    stiffness, mass = np.zeros((2, 194, 194))
    for k, (h, t, b) in enumerate(zip(lengths, thickness, width, strict=True)):
        turn, own = np.diag([1, h, 1, h]), slice(2 * k, 2 * k + 4)
        bent = [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
        moved = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
        stiffness[own, own] += MODULUS * b * t**3 / 12 / h**3 * turn @ bent @ turn
        mass[own, own] += DENSITY * b * t * h / 420 * turn @ moved @ turn
    slow = scipy.linalg.eigh(mass[2:, 2:], stiffness[2:, 2:], eigvals_only=True, subset_by_index=[190, 191])
    return 1 / (2 * np.pi * np.sqrt(slow[::-1]))


def slope(of, t_root: float, t_outer: float, variable: str, step: float = 1e-4):
    d_root, d_outer = (step, 0.0) if variable == "tr" else (0.0, step)
    return (of(t_root + d_root, t_outer + d_outer) - of(t_root - d_root, t_outer - d_outer)) / (2 * step)


def off(number: float, true: float) -> float:
    return (number - true) / abs(true)


def test_what_is_told_away_from_the_design_is_true(blade):
    """Of half the thickness outside: values, and gradients, that are off by 9 % to 23 times."""
    run = compiled(blade).statics({"to": 0.25}, gradients=True)
    told = run.verdict.measures["frozen_basis"]["errors"]
    true = {
        "ty": off(run.values["ty"], deflection(1.0, 0.25)),
        **{f"f{k + 1}": off(run.values[f"f{k + 1}"], each) for k, each in enumerate(frequencies(1.0, 0.25))},
    }
    for x in ("tr", "to"):
        true[f"the derivative of ty by {x}"] = off(run.gradients["ty"][x], slope(deflection, 1.0, 0.25, x))
        for k, each in enumerate(slope(frequencies, 1.0, 0.25, x)):
            true[f"the derivative of f{k + 1} by {x}"] = off(run.gradients[f"f{k + 1}"][x], each)
    assert max(map(abs, true.values())) > 20
    assert min(map(abs, true.values())) > 0.08
    assert told == pytest.approx(true, rel=0.01)
    assert not run.verdict.trusted
    assert "thickness_outer = 0.25 instead of 0.5" in str(run.verdict)


def test_what_more_frames_tell_of_a_frozen_basis_is_no_larger_than_it_is(blade):
    """Parts with frames of their own have all shapes: what is lacked by shapes does not fall with the frames, and is told as it is."""
    run = compiled(blade).statics({"to": 0.3}, gradients=True)
    told = run.verdict.measures["geometric_error"]
    assert told["responses"]["ty"] == pytest.approx(deflection(1.0, 0.3) - run.values["ty"], rel=0.02)
    for x in ("tr", "to"):
        assert told["gradients"]["ty"][x] == pytest.approx(slope(deflection, 1.0, 0.3, x) - run.gradients["ty"][x], rel=0.02)


def test_a_derivative_at_the_design_itself_is_told(blade):
    """The values are right there, and the derivative by the thickness that the basis does not follow is not."""
    run = compiled(blade).statics(gradients=True)
    true = off(run.gradients["ty"]["tr"], slope(deflection, 1.0, 0.5, "tr"))
    assert abs(off(run.values["f2"], frequencies(1.0, 0.5)[1])) < 1e-3
    assert abs(true) > 0.1
    assert run.verdict.measures["frozen_basis"]["errors"]["the derivative of ty by tr"] == pytest.approx(true, rel=0.01)
    assert "frozen-basis" in run.verdict.codes
    assert not run.verdict.trusted


def test_modes_away_from_the_design_are_told(blade):
    found, true = compiled(blade).modes({"to": 0.25}), frequencies(1.0, 0.25)[1]
    assert f"mode 2 is off by {found.frequencies[1] / true - 1:.0%}" in str(found.verdict)
    assert "left-out-shapes" not in found.verdict.codes  # whose bound is that of the design
    assert not found.verdict.trusted


@pytest.mark.parametrize(
    ("variables", "numbers"),
    [(("E", "rho"), {}), ((), {}), ((), {"E": 1.0e10, "rho": 800.0})],
    ids=["scales", "values", "scaled"],
)
def test_what_turns_no_shape_costs_nothing(blade, variables, numbers):
    """Modulus and density scale the matrices; values at the design itself are those of its own shapes."""
    run = compiled(blade, variables).statics(numbers, gradients=bool(variables))
    assert run.basis_errors is None
    assert "frozen-basis" not in run.verdict.codes


def test_a_basis_that_can_follow_is_trusted(tmp_path):
    run = compiled(written(tmp_path, RICH)).statics({"to": 0.49}, gradients=True)
    assert [run.values["f1"], run.values["f2"]] == pytest.approx(frequencies(1.0, 0.49), rel=0.01)
    assert run.gradients["ty"]["to"] == pytest.approx(slope(deflection, 1.0, 0.49, "to"), rel=0.02)
    assert "frozen-basis" not in run.verdict.codes


def test_of_a_file_without_more_shapes_it_is_not_known(blade, tmp_path):
    """Files of earlier versions: not known away from the design, trusted at it."""
    save(replace(load(blade.parent / "blade.h5"), **dict.fromkeys(RICHER_PARTS)), tmp_path / "blade.h5")
    (tmp_path / "scene.toml").write_text(SCENE)
    model = compiled(tmp_path / "scene.toml", ())
    assert model.statics().verdict.trusted
    verdict = model.statics({"to": 0.4}).verdict
    assert not verdict.trusted
    assert "thickness_outer = 0.4 instead of 0.5): by how much numbers are off is not known" in str(verdict)


def test_more_shapes_are_the_same_body_in_other_units(blade):
    model = load(blade.parent / "blade.h5")
    squares = [
        scipy.linalg.eigvalsh(each.invariants.stiffness, each.invariants.inertia[1:, 1:])
        for each in (richer_model(model), richer_model(converted_model(model, "mm-t-s")))
    ]
    assert squares[1] == pytest.approx(squares[0], rel=1e-6)


@pytest.mark.parametrize("part", [0.03, 0.23])
def test_the_certificate_judges_fresh_models_as_all_else(blade, part):
    """What models built afresh say of a frozen basis is a doubt above the limit of all gradients."""
    exact = direct(ffrf.read_scene(blade), ["tr"], "static")
    fresh = {f: {x: Fresh(each / (1 - part), 0.0) for x, each in row.items()} for f, row in exact.gradients.items()}
    told = [*doubts_of_fresh(FreshGradients(fresh, {}, {"tr": "frozen"}), exact)]
    assert [each.doubt for each in told] == [True] * (part > 0.05)


def stress(model, ratio: complex) -> np.ndarray:
    """Of a solid at all its points under unit forces and a moment at its tip, as its model tells it at a Poisson's ratio."""
    design = DesignPoint(model, {"poisson_ratio": ratio})
    tip = design.interface("tip")
    rows = np.vstack([tip.position[0][:, 1:], tip.rotation[0][1:]])
    return design.value("stress_operator") @ np.linalg.solve(design.value("stiffness"), rows.T)


def test_more_shapes_of_a_solid_follow_poissons_ratio(tmp_path):
    """Derivatives of the stress in frozen shapes are wrong; in more shapes they are those of all nodes, anew at other ratios."""
    mesh = rectangle("quad8", (6, 2), 1.0, 0.4)
    model = build(write_body(tmp_path, mesh, 'kind = "static"\nderivative = "frozen"'))
    full = write_body(tmp_path, mesh, 'kind = "full"')
    up, down = (stress(build(full, values={"poisson_ratio": ratio}), ratio) for ratio in (0.3 + 1e-4, 0.3 - 1e-4))
    slopes = [stress(each, 0.3 + 1e-30j).imag / 1e-30 for each in (model, richer_model(model))]
    wrong = [np.abs(each - (up - down) / 2e-4).max() / np.abs(up - down).max() * 2e-4 for each in slopes]
    assert wrong[0] > 0.1
    assert wrong[1] < 1e-5
    assert [name for name in model.parameters if turns(richer_model(model), name)] == ["poisson_ratio"]
