"""Beams cut into parts with frames of their own, against the elastica, corotational elements and the uncut body."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import ffrf
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from tests.models.beam_models import save_beam
from tests.models.rectangular_beams import corotational, points_of
from tests.validity.test_corotational import elastica
from toolkit.analyses.sensitivity.certificate.differences import taylor_rates
from toolkit.analyses.statics import solve_statics
from toolkit.api.model import Model
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import load, save
from toolkit.responses.shape_error import cut_positions
from toolkit.responses.stress import stress_field
from toolkit.scene.resolution import resolve
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.corotational_beams import solve_corotational
from toolkit.validity.energy_balance import energy_balance

SECTION = Section(youngs_modulus=1e9, density=1000.0, thickness=0.01, width=0.02, damping_stiffness=1e-3)
EI = SECTION.youngs_modulus * SECTION.width * SECTION.thickness**3 / 12
STRAIGHT = np.column_stack([np.linspace(0, 1, 17), np.zeros(17)])
ARC = np.column_stack([np.sin(np.linspace(0, 2, 7)), 1 - np.cos(np.linspace(0, 2, 7))])

CANTILEVER = """units = "m-kg-s"
[points]
tip = { body = "beam", interface = "tip" }
middle = { body = "beam", interface = "middle" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded", frames = FRAMES, position = [0.3, -0.2], angle = 0.4 }
[loads]
pull = { type = "point-force", body = "beam", point = "tip", force = [FORCE_X, FORCE_Y] }
turn = { type = "torque", body = "beam", point = "tip", torque = MOMENT }
[design]
t = "bodies.beam.thickness"
F = "loads.pull.force.y"
turned = "bodies.beam.angle"
[responses]
x = { type = "displacement", body = "beam", point = "tip", component = "x" }
y = { type = "displacement", body = "beam", point = "tip", component = "y" }
within = { type = "displacement", body = "beam", point = "middle", component = "y" }
stress = { type = "max-stress", body = "beam", measure = "absolute" }
"""


def cantilever(
    folder: Path, nodes: np.ndarray, frames: object, force: tuple[float, float], moment: float = 0.0, **basis
) -> Scene:
    """Clamped at its first node, loaded at its last; the point `middle` lies inside of an element."""
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()
    save_beam(folder / "beam.h5", nodes, SECTION, {"tip": length, "middle": 0.45 * length}, **basis)
    text = CANTILEVER.replace("FRAMES", str(frames)).replace("MOMENT", repr(float(moment)))
    for name, value in zip(("FORCE_X", "FORCE_Y"), force, strict=True):
        text = text.replace(name, repr(float(value)))
    (folder / "scene.toml").write_text(text)
    return ffrf.read_scene(folder / "scene.toml")


def without_elements(file: Path) -> None:
    """What files of models of shapes were before they kept their elements."""
    kept = load(file)
    save(replace(kept, elements=None, element_derivatives=None, element_affine=None), file)


def in_space(local: tuple[float, float]) -> tuple[float, float]:
    """A vector of the body's axes, which stand at 0.4 rad."""
    c, s = np.cos(0.4), np.sin(0.4)
    return c * local[0] - s * local[1], s * local[0] + c * local[1]


@pytest.mark.parametrize(
    ("load", "others"),
    [(0.5, (1.8, 0.50, 0.13, 0.033)), (1.0, (3.9, 1.0, 0.25, 0.063)), (3.0, (10.8, 2.4, 0.55, 0.14))],
    ids=["14 degrees", "26 degrees", "56 degrees"],
)
def test_a_tip_load_bends_parts_into_the_elastica(tmp_path, load, others):
    """Percent of the tip's displacement for one chord frame, 2, 4 and 8: those of linear pieces in a row, measured apart. The error
    falls at least threefold with every doubling: it is of second order, with some of the fourth at one frame."""
    down, short = elastica(load)
    wanted = np.array(in_space((-short, down)))
    errors = []
    for frames, most in zip(("[]", 2, 4, 8), others, strict=True):
        scene = cantilever(tmp_path, STRAIGHT, frames, in_space((0.0, load * EI)))
        found = ffrf.compile(scene).statics().values
        errors.append(100 * np.linalg.norm([found["x"], found["y"]] - wanted) / np.hypot(down, short))
        assert errors[-1] < 1.01 * most  # its digits
    assert all(one > 3 * other for one, other in pairwise(errors))


@pytest.mark.parametrize("nodes", [STRAIGHT[:7], ARC])
def test_one_frame_per_element_is_the_corotational_beam(tmp_path, nodes):
    """The chord of an element is the frame of the corotational element, so that its tip, nodes and stresses are the same to round-off."""
    n, length = len(nodes) - 1, np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()
    force, moment = (-0.5 * EI / length**2, EI / length**2), 0.3 * EI / length
    scene = cantilever(tmp_path, nodes, n, in_space(force), moment)
    solution = solve_statics(compile_scene(scene))
    connectivity = np.column_stack([np.arange(n), np.arange(1, n + 1)])
    judge = corotational(nodes, connectivity, SECTION.youngs_modulus, SECTION.thickness, SECTION.width)
    loads = np.append(np.zeros(3 * n), [*force, moment])
    u = solve_corotational(judge, loads, np.eye(3, 3 * n + 3))
    places, _ = cut_positions(solution.system.scene, "beam", solution.q[-1, solution.coordinates("beam")])
    assert np.abs(u[2::3]).max() > 0.4  # rad: it bends far
    np.testing.assert_allclose(places, nodes + u.reshape(-1, 3)[:, :2], atol=1e-9)  # both solvers stop at 1e-10 of the size
    stress = stress_field(solution, "beam")[0][-1]
    np.testing.assert_allclose(stress, judge.stress(u, points_of(n)), atol=1e-7 * np.abs(stress).max())  # E times that


@pytest.mark.parametrize("frames", [1, 3, 10, 30, "[5, 9]"])
def test_gradients_of_parts_are_complex_steps(tmp_path, frames):
    """Direct, adjoint and complex step, of cuts at uneven nodes too; what is left beside them vanishes with the square of the change."""
    design = ["t", "F", "turned"]
    scene = cantilever(tmp_path, np.linspace((0.0, 0.0), (1.0, 0.0), 31), frames, in_space((0.0, EI)))
    agree(ffrf.compile(scene, variables=design), "statics")
    assert taylor_rates(scene, design, "static") == pytest.approx(
        dict.fromkeys(scene.responses, 2.0), abs=0.02
    )  # third derivatives


FORMULATIONS = {
    "index-3": {"formulation": "index-3"},
    "ggl": {"formulation": "ggl"},
    "paper": {"scheme": "paper", "rho_inf": 1.0},
    "changing steps": {"local_error": 1e-4},
    "quasi-static": {"quasi_static": True},
}


@pytest.mark.parametrize("options", FORMULATIONS.values(), ids=FORMULATIONS)
@pytest.mark.parametrize("frames", [1, 3, 10])
def test_gradients_of_parts_are_complex_steps_in_every_formulation(tmp_path, frames, options):
    """Let go from its straight shape; stabilised index 2 has no backward run."""
    scene = cantilever(tmp_path, STRAIGHT[:11], frames, in_space((0.0, EI)))
    solver = {"end_time": 0.002, "step": 0.001, "tolerance": 1e-13, **options}
    methods = ("direct",) if "ggl" in options.values() else ("direct", "adjoint")
    model = ffrf.compile(scene.model_copy(update={"solver": RunOptions(**solver)}), variables=["t", "F", "turned"])
    agree(model, "simulate", methods)


def agree(model: Model, analysis: str, methods: tuple[str, ...] = ("direct", "adjoint")) -> None:
    """Methods and complex step to 1e-9 of the largest of each response by its own scale."""
    exact, *others = (getattr(model, analysis)(gradients=method).gradients for method in ("complex-step", *methods))
    for response, by in exact.items():
        for found in others:
            for name, value in by.items():
                size = max(abs(each * model.variables[x]) for x, each in by.items()) / abs(model.variables[name] or 1.0)
                assert found[response][name] == pytest.approx(value, rel=1e-9, abs=1e-10 * size), (response, name)


REST = """units = "m-kg-s"
[points]
hub = { body = "beam", interface = "hub" }
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frames = FRAMES }
[joints]
hub = { type = "revolute", bodies = ["beam", "ground"], point = "hub" }
[loads]
weight = { type = "gravity", acceleration = [0.0, -9.81] }
coil = { type = "rotational-spring-damper", bodies = ["beam", "ground"], point = "hub", stiffness = 5.0, damping = 0.3 }
[design]
t = "bodies.beam.thickness"
k = "loads.coil.stiffness"
[responses]
y = { type = "displacement", body = "beam", point = "tip", component = "y" }
force = { type = "joint-force", joint = "hub", component = "y" }
stress = { type = "max-stress", body = "beam" }
[solver]
end_time = 0.05
step = 0.01
start = "equilibrium"
tolerance = 1e-13
"""


@pytest.mark.parametrize("frames", [1, 3])
def test_what_starts_in_equilibrium_stays_there_with_its_gradients(tmp_path, frames):
    """Those of statics. Accelerations found from the round-off of elastic forces put gradients of the joint's force off by 2e-8."""
    save_beam(tmp_path / "beam.h5", np.linspace((0.0, 0.0), (1.0, 0.0), 33), SECTION, {"hub": 0.0, "tip": 1.0})
    (tmp_path / "scene.toml").write_text(REST.replace("FRAMES", str(frames)))
    model = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml"), variables=["t", "k"])
    run, rest = model.simulate(gradients=True), model.statics(gradients=True)
    assert run.values == pytest.approx(rest.values, rel=1e-12)
    for response, by in rest.gradients.items():  # the force is the weight, whatever the coil
        assert run.gradients[response] == pytest.approx(by, rel=1e-9, abs=1e-9), response


SWING = """units = "m-kg-s"
[points]
hub = { body = "beam", interface = "hub" }
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frames = 4, angular_velocity = 1.5, angle = 0.2 }
[joints]
hub = { type = "revolute", bodies = ["beam", "ground"], point = "hub" }
[loads]
weight = { type = "gravity", acceleration = [0.0, -9.81] }
[design]
t = "bodies.beam.thickness"
rho = "bodies.beam.density"
omega = "bodies.beam.angular_velocity"
[responses]
y = { type = "displacement", body = "beam", point = "tip", component = "y" }
stress = { type = "ks-stress", body = "beam", aggregation = 10.0, reference_stress = 1e6 }
kinetic = { type = "kinetic-energy", body = "beam" }
centre = { type = "centre-of-mass", component = "y" }
[solver]
end_time = 0.2
step = 0.01
rho_inf = 0.8
"""


def test_a_heavy_beam_swings_with_exact_gradients_and_keeps_its_energy(tmp_path):
    """Its start holds all parts at the same angular velocity; work of gravity, motion, strain and damping balance."""
    save_beam(tmp_path / "beam.h5", STRAIGHT[::2], SECTION, {"hub": 0.0, "tip": 1.0})
    (tmp_path / "scene.toml").write_text(SWING)
    model = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml"), variables=["t", "rho", "omega"])
    agree(model, "simulate")
    solution = model.simulate().solution
    defects = [energy_balance(model.simulate({"solver.step": step}).solution).relative_defect for step in (0.01, 0.005)]
    assert defects[0] < 0.01
    assert defects[0] > 3 * defects[1]  # the scheme's, of second order in the step
    assert np.ptp([solution.v[0, solution.coordinates(f"beam[{k}]")][2] for k in (1, 2, 3, 4)]) < 1e-9
    assert solution.v[0, solution.coordinates("beam")][2] == pytest.approx(1.5, abs=1e-12)


def test_elements_add_up_to_the_invariants_of_the_body(tmp_path):
    """At another design too, by the polynomials of the elements."""
    save_beam(tmp_path / "beam.h5", ARC, SECTION, {"tip": 0.5}, separate=("thickness",))
    model = load(tmp_path / "beam.h5")
    elements = model.elements
    assert elements is not None
    n = 3 * len(elements.nodes)
    stiffness, inertia, gyroscopic = np.zeros((n, n)), np.zeros((1 + n, 1 + n)), np.zeros((1 + n, 1 + n))
    for e, nodes in enumerate(elements.connectivity):
        own = (3 * nodes[:, None] + np.arange(3)).ravel()
        z = np.append(0, 1 + own)
        stiffness[np.ix_(own, own)] += elements.stiffness[e]
        inertia[np.ix_(z, z)] += elements.inertia[e]
        gyroscopic[np.ix_(z, z)] += elements.gyroscopic[e]
    kept, inv = np.append(0, np.arange(4, 1 + n)), model.invariants  # the first node is clamped
    for found, whole in (
        (stiffness[3:, 3:], inv.stiffness),
        (inertia[np.ix_(kept, kept)], inv.inertia),
        (gyroscopic[np.ix_(kept, kept)], inv.gyroscopic),
    ):
        np.testing.assert_allclose(found, whole, atol=1e-13 * np.abs(whole).max())  # round-off of sums
    assert elements.mass.sum() == pytest.approx(float(inv.mass), rel=1e-13)


def test_to_the_scene_it_stays_one_body(tmp_path):
    scene = cantilever(tmp_path, STRAIGHT, 4, (0.0, EI))
    cut = resolve(scene)
    assert list(cut.all_bodies()) == ["ground", "beam", "beam[1]", "beam[2]", "beam[3]", "beam[4]"]
    assert list(cut.joints) == [f"beam at node {k}" for k in (4, 8, 12, 0)]
    assert cut.written == scene
    assert resolve(cut) is cut
    assert dict(resolve(cut.written)) == dict(cut)
    assert scene.available_paths() == cut.available_paths()


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        (17, "has 16 elements, and a frame needs one at least. Write at most 16"),
        ("[0]", "the nodes between the ends of the body are 1 to 15"),
        ("[4, 4]", "cuts at node 4, where another cut is already"),
        ("['middle']", "lies inside element 7 and not at a node. Cut at node 7 or 8"),
        ("['tip']", "cuts at node 16, where an end of the body is already"),
        ("['top']", "has no interface point 'top'"),
    ],
)
def test_cuts_that_cannot_be_are_refused(tmp_path, frames, words):
    scene = cantilever(tmp_path, STRAIGHT, frames, (0.0, EI))
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        compile_scene(scene)


def test_parts_of_a_model_of_shapes_have_all_coordinates(tmp_path):
    """Whatever shapes its one frame keeps, so that they bend as those of a model of all coordinates."""
    found = []
    for basis in ("full", "eigenmodes"):
        scene = cantilever(
            tmp_path, STRAIGHT, 4, in_space((0.0, EI)), basis=BasisChoice(basis, count=1 if basis != "full" else None)
        )
        found.append(ffrf.compile(scene, variables=["t", "F"]).statics(gradients=True))
    full, reduced = found
    assert reduced.values == pytest.approx(full.values, rel=1e-9)
    for f, slopes in full.gradients.items():
        assert reduced.gradients[f] == pytest.approx(slopes, rel=1e-8)


def test_a_model_without_elements_is_refused(tmp_path):
    cantilever(tmp_path, STRAIGHT, 4, (0.0, EI), basis=BasisChoice("eigenmodes", count=4))
    without_elements(tmp_path / "beam.h5")
    with pytest.raises(InputError, match=r"does not keep its elements one by one.* Build it again with ffrf-preprocess"):
        compile_scene(ffrf.read_scene(tmp_path / "scene.toml"))


@pytest.mark.parametrize(("load", "told"), [(0.5, True), (0.02, False)])
def test_gradients_of_a_reduced_beam_are_judged_by_the_elastica(tmp_path, load, told):
    """Its modes bend in one frame, and what its elements would do when they turn is told of every gradient to a factor of 1.5."""
    scene = cantilever(tmp_path, STRAIGHT, 1, in_space((0.0, load * EI)), basis=BasisChoice("craig-bampton", count=2))
    run = ffrf.compile(scene, variables=["t"]).statics(gradients=True)
    step = 1e-3  # of the load, which the bending stiffness divides: it grows with the cube of the thickness
    down, short = -3 * np.subtract(elastica(load * (1 + step)), elastica(load * (1 - step))) / (2 * step) / SECTION.thickness
    assert ("geometric-gradients" in {each.code for each in run.verdict.warnings if each.doubt}) == told
    for f, true in zip("xy", in_space((-short, down)), strict=True):
        off = true - run.gradients[f]["t"]
        if told:
            assert 1 / 1.5 < run.frame_errors.gradients[f]["t"] / off < 1.5
        else:
            assert abs(off) < 0.05 * abs(true)


def test_what_asks_for_the_one_frame_is_refused(tmp_path):
    """The shape at the start, and the deflection in the frame, are those of a body with one frame."""
    scene = cantilever(tmp_path, STRAIGHT, 4, (0.0, EI))
    bent = scene.bodies["beam"].model_copy(update={"deflection": {"tip": (0.0, 0.1)}})
    with pytest.raises(InputError, match="is the shape of a body with one frame"):
        compile_scene(scene.model_copy(update={"bodies": {"beam": bent}}))
    text = (tmp_path / "scene.toml").read_text() + 'own = { type = "deflection", body = "beam", point = "tip" }\n'
    (tmp_path / "scene.toml").write_text(text)
    with pytest.raises(InputError, match="and it has several: no frame is that of the whole body"):
        ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()
