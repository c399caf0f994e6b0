"""One design variable that drives several numbers: gradients in every analysis and by every method, values, files, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ffrf
from tests.models.cases import write_models
from tests.models.every_number import SCENES
from tests.models.scenes import MODELS, WING
from tests.models.spatial_cases import write_models as write_spatial_models
from tests.models.spatial_every_number import SCENES as SPATIAL
from toolkit.analyses.sensitivity.certificate.differences import taylor_rates
from toolkit.analyses.sensitivity.certificate.fresh_models import disagreements, fresh_gradients
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.analyses.sensitivity.run import restored
from toolkit.description.design import CommonVariable
from toolkit.files.gradient_units import gradient_unit
from toolkit.files.results import collect
from toolkit.files.results_file import load_results, save_results
from toolkit.files.scene_reader import read_scene, scene_from_table
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.studies.stability.study import stability
from toolkit.studies.tradeoff.tradeoff import plan, tradeoff

EXACT = 1e-10
"""Of the largest derivative: round-off of sums of a few derivatives."""
PENDULUM = MODELS.parent / "pendulum" / "scene.toml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    write_spatial_models(directory)
    return directory


def with_design(scene: Scene, **design: CommonVariable) -> Scene:
    return scene.model_copy(update={"design": design})


def joined(scene: Scene, *paths: str, factors: tuple[float, ...]) -> Scene:
    return with_design(scene, together=CommonVariable(of=paths, factors=factors))


CASES = {
    "plane, motion": ("rods", 2, "transient", ("points.A.x", "points.D.y", "points.C.x"), (1.0, -0.7, 2.0)),
    "plane, at rest": ("swing", 2, "static", ("loads.spring.stiffness", "loads.relaxed.stiffness"), (1.0, 0.3)),
    "curves": ("rods", 2, "transient", ("joints.lead.curve.terms.1.height", "joints.lead.curve.terms.0.value"), (1.0, -0.2)),
    "parameters of a model": (
        "beams",
        2,
        "transient",
        ("bodies.skin.thickness", "bodies.skin.width", "bodies.strip.width"),
        (1.0, -0.5, 0.4),
    ),
    "parameters of a model at rest": ("beams", 2, "static", ("bodies.skin.thickness", "bodies.skin.width"), (0.5, -2.0)),
    "space, motion": ("linkage", 3, "transient", ("points.A.z", "points.C.x", "points.E.y"), (1.0, -0.7, 2.0)),
    "space, at rest": (
        "frames",
        3,
        "static",
        tuple(f"bodies.{name}" for name in ("mast.width_bar", "mast.diameter_pipe", "strip.width_bar")),
        (1.0, 0.5, -0.3),
    ),
}


@pytest.fixture(scope="module", params=CASES)
def case(request, folder) -> tuple[Scene, str, tuple[str, ...], tuple[float, ...]]:
    name, dimension, kind, paths, factors = CASES[request.param]
    scene = (SCENES if dimension == 2 else SPATIAL)[name](folder)
    return joined(scene, *paths, factors=factors), kind, paths, factors


def test_a_gradient_is_the_sum_of_those_by_the_numbers_by_every_method(case):
    scene, kind, paths, factors = case
    single = gradients_by("complex-step", scene, list(paths), kind).gradients
    for method in ("direct", "adjoint", "complex-step"):
        found = gradients_by(method, scene, ["together"], kind).gradients
        for response, slopes in single.items():
            expected = sum(factor * slopes[path] for path, factor in zip(paths, factors, strict=True))
            size = sum(abs(factor * slopes[path]) for path, factor in zip(paths, factors, strict=True))
            assert found[response]["together"] == pytest.approx(expected, abs=10 * EXACT * size), (response, method)


def test_differences_move_all_numbers(case):
    scene, kind, _, _ = case
    exact = gradients_by("direct", scene, ["together"], kind).gradients
    found = gradients_by("central-difference", scene, ["together"], kind).gradients
    for response, slopes in exact.items():
        # step 1e-5: truncation 1e-10 relative, round-off 1e-16 / 1e-5 of values that may be 1000 times the slope
        assert found[response]["together"] == pytest.approx(slopes["together"], rel=1e-4, abs=1e-7), response


def test_a_value_moves_all_numbers_and_renews_the_compiled_model(case):
    scene, kind, paths, factors = case
    model = ffrf.compile(scene, ["together"])
    old = model.variables["together"]
    assert old == pytest.approx(scene.number(paths[0]) / factors[0])
    run = {"transient": model.simulate, "static": model.statics}[kind]
    by_hand = scene
    for path, factor in zip(paths, factors, strict=True):
        by_hand = by_hand.with_number(path, scene.number(path) + factor * 0.01)
    found, expected = run({"together": old + 0.01}, gradients=True), direct(by_hand, ["together"], kind)
    assert found.values == pytest.approx(expected.values, rel=1e-9)
    for response, slopes in expected.gradients.items():
        assert found.gradients[response] == pytest.approx(slopes, rel=1e-7), response
    assert model.at({"together": old + 0.01}).variables["together"] == pytest.approx(old + 0.01)


def wing_text(line: str) -> str:
    text = WING.read_text()
    return text.replace("[design]\n", f"[design]\n{line}\n")


@pytest.fixture
def wing(tmp_path):
    """A wing's file with another line in its table of variables, beside links to its models."""

    def write(line: str) -> Path:
        file = tmp_path / "scene.toml"
        file.write_text(wing_text(line))
        for each in WING.parent.iterdir():
            if each.name != "scene.toml" and not (tmp_path / each.name).exists():
                (tmp_path / each.name).symlink_to(each)
        return file

    return write


LINE = 'beside = { of = ["points.A.x", "points.B.x", "points.D.x"], factors = [1.0, 0.5, -2.0] }'
SHORT = {"solver.end_time": 0.1, "solver.step": 0.05}


def without_twin(file: Path) -> Path:
    """The wing's own variable of points.A.x is left out."""
    file.write_text(file.read_text().replace('x_A = "points.A.x"\n', ""))
    return file


RODS = """
units = "m-kg-s"
[points]
L = [0.0, 0.0]
P = [1.0, 0.0]
Q = [2.0, 0.0]
[bodies]
a = { type = "rod", between = ["L", "P"], area = 1e-3, density = 1000.0 }
b = { type = "rod", between = ["P", "Q"], area = 2e-3, density = 1000.0 }
[joints]
v = { type = "revolute", bodies = ["a", "ground"], point = "L" }
w = { type = "revolute", bodies = ["a", "b"], point = "P" }
[loads]
g = { type = "gravity", acceleration = [0.5, -9.81] }
[design]
A = { of = ["bodies.a.area", "bodies.b.area"], factors = [2.0, 1.0] }
X = { of = ["points.P.x", "points.Q.x"], factors = [1.0, 3.0] }
G = { of = ["loads.g.acceleration.x", "loads.g.acceleration.y"], factors = [1.0, 2.0] }
[responses]
m = { type = "mass" }
c = { type = "centre-of-mass", component = "y" }
mean = { type = "time-mean", of = { type = "centre-of-mass", component = "y" } }
power = { type = "power", load = "g" }
work = { type = "work", load = "g" }
kinetic = { type = "kinetic-energy" }
[solver]
end_time = 0.1
step = 0.001
"""


@pytest.mark.parametrize("method", ["direct", "adjoint"])
def test_masses_centres_powers_and_works_follow_all_numbers(tmp_path, method):
    """The mass a rho l_a + b rho l_b grows by 2000 + 1000 kg/m^2 with A, and with X by 1 + 2 (3 - 1) kg/m."""
    (tmp_path / "scene.toml").write_text(RODS)
    model = ffrf.compile(read_scene(tmp_path / "scene.toml"), ["A", "X", "G"])
    exact, judge = model.simulate(gradients=method).gradients, model.simulate(gradients="complex-step").gradients
    assert (exact["m"]["A"], exact["m"]["X"]) == pytest.approx((3000.0, 5.0), rel=1e-12)
    for response, slopes in judge.items():
        for name, slope in slopes.items():  # Newton's tolerance of 1e-10
            assert exact[response][name] == pytest.approx(slope, rel=1e-9, abs=1e-9), (response, name)


def test_a_variable_and_one_of_its_numbers_are_not_both_given(tmp_path):
    (tmp_path / "scene.toml").write_text(RODS)
    with pytest.raises(InputError, match=r"'A' drives bodies\.b\.area, which is given a value of its own too\. Give one of them"):
        read_scene(tmp_path / "scene.toml", {"A": 2e-3, "bodies.b.area": 3e-3})


def test_a_value_in_a_command_is_that_of_the_first_number_over_its_factor(wing):
    file = without_twin(wing(LINE))
    scene, other = read_scene(file), read_scene(file, {"beside": "73.5"})
    assert scene.value_of("beside") == 72.5
    moves = {path: other.number(path) - scene.number(path) for path in scene.paths_of("beside")}
    assert moves == pytest.approx({"points.A.x": 1.0, "points.B.x": 0.5, "points.D.x": -2.0}, abs=1e-13)  # last digits of 75
    with pytest.raises(InputError, match=r"beside = 'far' is no number"):
        read_scene(file, {"beside": "far"})
    with pytest.raises(InputError, match=r"'points\.B\.x' is the same number as another one that is given, points\.B\.x"):
        ffrf.compile(scene).at({"beside": 73.0, "points.B.x": 70.0})


def test_numbers_that_are_equal_share_their_value_to_the_last_digit():
    rod = {"type": "rod", "area": 0.1, "density": 0.3}
    common = {"of": ["bodies.a.area", "bodies.b.area"]}
    scene = Scene(
        units="m-kg-s",
        points={"O": ffrf.plane.Point(x=0.0, y=0.0), "A": ffrf.plane.Point(x=1.0, y=0.0)},
        bodies={name: ffrf.plane.Rod(between=("O", "A"), **{k: v for k, v in rod.items() if k != "type"}) for name in "ab"},
        design={"area": common},
    )
    other = ffrf.compile(scene).at({"area": 0.7}).scene
    assert [other.number(path) for path in common["of"]] == [0.7, 0.7]


def test_modes_follow_a_value(wing):
    scene = read_scene(without_twin(wing(LINE)))
    by_hand = {"points.A.x": 73.0, "points.B.x": 75.55, "points.D.x": 60.8}
    model = ffrf.compile(scene, ["beside"])
    found, expected = (model.modes(numbers, count=3).frequencies for numbers in ({"beside": 73.0}, by_hand))
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert abs(found[0] / model.modes(count=3).frequencies[0] - 1) > 1e-6


def test_a_results_file_keeps_what_it_drives_and_brings_its_derivatives_back(wing, tmp_path):
    scene = read_scene(without_twin(wing(LINE)), SHORT)
    found = direct(scene, ["beside", "t_w"], "transient")
    save_results(collect(found), tmp_path / "wing.h5")
    results = load_results(tmp_path / "wing.h5")
    assert results.variables["beside"] == {
        "path": "points.A.x",
        "value": 72.5,
        "of": ["points.A.x", "points.B.x", "points.D.x"],
        "factors": [1.0, 0.5, -2.0],
    }
    assert results.variables["t_w"] == {"path": "bodies.skin.thickness", "value": 1.5}
    solution = restored(results).solution
    for name, response in scene.responses.items():
        assert response.gradient(solution) == pytest.approx(list(found.gradients[name].values()), rel=1e-12), name
    assert gradient_unit(scene, "drive_angle", "beside") == "rad / mm"


def test_certificates_hold(wing):
    """Taylor's remainder along it vanishes in second order; and models built afresh with both numbers changed agree."""
    file = wing('sheet = { of = ["bodies.skin.width", "bodies.skin.thickness", "points.B.x"], factors = [1.0, -0.02, 0.3] }')
    file.write_text(file.read_text().replace('t_w = "bodies.skin.thickness"\n', ""))
    scene = read_scene(file)
    exact = direct(scene, ["sheet"], "static")
    for response, rate in taylor_rates(scene, ["sheet"], "static", exact=exact).items():
        assert rate > 1.85, response  # 2, or more where the second derivative happens to be small; 1 if the gradient is wrong
    fresh = fresh_gradients(scene, ["sheet"], "static", lambda *_: None)
    assert set(fresh.slopes) == set(exact.gradients)
    assert list(disagreements(fresh, exact)) == []


def test_studies_take_it():
    """The pendulum's length is minus x of its mass: the same study but for the sign."""
    scene = with_design(
        read_scene(PENDULUM, {"solver.end_time": 0.5, "solver.step": 0.005}),
        length=CommonVariable(of=("points.P.x",), factors=(-1.0,)),
    )
    studies = [stability(scene, [name], ["units"], most_steps=2000) for name in ("length", "points.P.x")]
    words = [[cell.gradient.name for cell in study.maps[0].cells.values()] for study in studies]
    assert words[0] == words[1]
    assert set(words[0]) == {"stable"}
    of_length, of_x = (study.own.outcome.gradients for study in studies)
    for response, slopes in of_x.items():
        assert of_length[response]["length"] == pytest.approx(-slopes["points.P.x"], rel=1e-9), response


def test_a_tradeoff_measures_its_gradients(tmp_path):
    text = PENDULUM.read_text().replace('x_P = "points.P.x"', 'length = { of = ["points.P.x"], factors = [-1.0] }')
    (tmp_path / "scene.toml").write_text(text.replace('m = "bodies.bob.mass"', ""))
    changes = {"solver.end_time": "1.0", "solver.step": "0.02"}
    found = tradeoff(plan(tmp_path / "scene.toml", tmp_path / "runs", changes, axes="step=0.02/0.01"), repeats=2)
    exact = direct(read_scene(tmp_path / "scene.toml", {"solver.end_time": 1.0, "solver.step": 1e-3}), ["length"], "transient")
    slopes = found.reference.slopes
    for response, of in exact.gradients.items():
        # the step of 1e-3 is the coarser of both: second order, 1e-6 times the square of 3 rad / s
        assert slopes[response]["length"].value == pytest.approx(of["length"], rel=1e-3, abs=1e-4), response


WRONG = {
    "an unknown path": (
        'w = { of = ["points.Q.x", "points.A.y"] }',
        r"design\.w: the path 'points\.Q\.x' of design variable 'w' leads nowhere",
    ),
    "a path in two variables": (
        'w = { of = ["bodies.skin.thickness"] }',
        r".*the same number, bodies\.skin\.thickness",
    ),
    "one of its paths in two variables": (
        'w = { of = ["points.B.x", "points.A.x"] }',
        r".*design variables 'w' and 'x_A' both drive points\.A\.x. Leave it to one of them",
    ),
    "factors of other length": (
        'w = { of = ["points.B.x", "points.C.x"], factors = [1.0] }',
        r"design\.w: 2 paths but 1 factors; give as many of each, or no factors if all are one",
    ),
    "a zero factor": (
        'w = { of = ["points.B.x", "points.C.x"], factors = [1.0, 0.0] }',
        r"design\.w: the factor of points\.C\.x is zero, so that nothing drives it; leave it out of `of`",
    ),
    "a number twice": ('w = { of = ["points.B.x", "points.B.x"] }', r"design\.w: `of` names points\.B\.x twice"),
    "no number": ("w = { of = [] }", r"design\.w\.of: .*at least 1 item"),
    "other units": (
        'w = { of = ["bodies.skin.width", "bodies.skin.youngs_modulus"] }',
        r"design\.w: design variable 'w' drives bodies\.skin\.width and bodies\.skin\.youngs_modulus, which measure different things",
    ),
    "a number of the solver": (
        'w = { of = ["solver.step"] }',
        r"design\.w: 'solver\.step' cannot be a design variable: step, stabilisation",
    ),
    "a misspelt key": (
        'w = { off = ["points.B.x"] }',
        r"design\.w\.off: unknown key, did you mean 'of'; possible here: of, factors",
    ),
    "the path of another number": (
        '"points.A.y" = "loads.drive.torque"',
        r"design\.points\.A\.y: that is the path of a number, and the variable drives loads\.drive\.torque instead",
    ),
    "a number": ("w = 3.0", r"design\.w: a design variable is the path of a number, .* or a table"),
}


@pytest.mark.parametrize("mistake", WRONG)
def test_wrong_variables_are_refused_in_words(wing, mistake):
    line, words = WRONG[mistake]
    with pytest.raises(InputError, match=rf"scene\.toml: {words}"):
        read_scene(wing(line))


def test_numbers_name_those_of_a_pair_too():
    """Two coefficients are taken for a vector of the plane, where three have numbers alone."""
    table = {"type": "torque", "body": "b", "point": "P", "torque": 1.0}
    for coefficients, names in (((1.0, 2.0), ("x", "y")), ((1.0, 2.0, 3.0), ("0", "1"))):
        scene = scene_from_table(
            {
                "units": "m-kg-s",
                "points": {"O": [0.0, 0.0], "P": [1.0, 0.0]},
                "bodies": {"b": {"type": "rigid", "mass": 1.0, "center": "P", "inertia": 0.1}},
                "loads": {"t": {**table, "curve": {"type": "polynomial", "coefficients": list(coefficients)}}},
                "design": {"c": "loads.t.curve.coefficients.1"},
            },
            Path("scene.toml"),
        )
        assert next(iter(scene.design_variables(["c"]))).path == f"loads.t.curve.coefficients.{names[1]}"
        assert scene.with_number("loads.t.curve.coefficients.0", 7.0).number(f"loads.t.curve.coefficients.{names[0]}") == 7.0
