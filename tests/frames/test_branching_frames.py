"""Frames of beams that branch, turn round and close, cut into chains with frames of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ffrf
from preprocessing import build, save
from tests.frames.test_cut_bodies import agree
from tests.models.rectangular_beams import corotational, points_of
from toolkit.analyses.sensitivity.certificate.whole_mechanism import compare_mechanism
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import load
from toolkit.render.plane.configuration import Configuration, skin_shape
from toolkit.scene.resolution import resolve
from toolkit.scene.scene import Scene
from toolkit.studies.tradeoff.axes import read_axes
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.corotational_beams import solve_corotational
from toolkit.validity.bodies.deformation import largest_displacement, largest_distance, node_places

FORK = {"A": (0.0, 0.0), "B": (0.5, 0.0), "C": (0.9, 0.3), "D": (0.9, -0.3)}
BEAMS = (("A", "B"), ("B", "C"), ("D", "B"))
"""The last one runs towards the node where all three meet."""
DIAMOND = {"A": (0.0, 0.0), "B": (0.5, 0.2), "C": (1.0, 0.0), "D": (0.5, -0.2)}
ROUND = (("A", "B"), ("B", "C"), ("C", "D"), ("D", "A"))


def save_frame(folder: Path, nodes: dict[str, tuple[float, float]], beams, elements: int, dimension: int = 2) -> None:
    """Equal beams between named nodes; in space in the plane z = 0, with the thickness in it."""
    zero, twist = ([0.0], "poisson_ratio = 0.3, ") if dimension == 3 else ([], "")
    across = ", orientation = [0.0, 0.0, 1.0]" if dimension == 3 else ""
    listed = ", ".join(f"{name} = {[*place, *zero]}" for name, place in nodes.items())
    rods = ", ".join(f'{{ from = "{a}", to = "{b}", section = "s", elements = {elements}{across} }}' for a, b in beams)
    (folder / "frame.toml").write_text(f"""units = "m-kg-s"
dimension = {dimension}
clamp = ["A"]
nodes = {{ {listed} }}
beams = [{rods}]
interface_points = {{ root = {{ node = "A" }}, joint = {{ node = "B" }}, tip = {{ node = "C" }}, low = {{ node = "D" }} }}
[sections]
s = {{ kind = "rectangle", thickness = 0.01, width = 0.02, material = "m" }}
[materials]
m = {{ youngs_modulus = 1e9, {twist}density = 1000.0 }}
""")
    save(build(folder / "frame.toml"), folder / "frame.h5")


def scene_of(folder: Path, frames: object, dimension: int = 2, body: str = 'frame = "grounded", ', rest: str = "") -> Scene:
    """Pulled at two of its ends."""
    zero = ", 0.0" if dimension == 3 else ""
    points = "\n".join(f'{name} = {{ body = "fork", interface = "{name}" }}' for name in ("root", "joint", "tip", "low"))
    (folder / "scene.toml").write_text(f"""units = "m-kg-s"
dimension = {dimension}
[points]
{points}
[bodies]
fork = {{ type = "flexible", model = "frame.h5", {body}frames = {frames} }}
[loads]
pull = {{ type = "point-force", body = "fork", point = "tip", force = [0.5, 2.0{zero}] }}
low = {{ type = "point-force", body = "fork", point = "low", force = [0.5, 1.0{zero}] }}
[design]
t = "bodies.fork.thickness_s"
x = "bodies.fork.x_B"
[responses]
x = {{ type = "displacement", body = "fork", point = "tip", component = "x" }}
y = {{ type = "displacement", body = "fork", point = "tip", component = "y" }}
low = {{ type = "displacement", body = "fork", point = "low", component = "y" }}
stress = {{ type = "max-stress", body = "fork", measure = "absolute" }}
{rest}""")
    return ffrf.read_scene(folder / "scene.toml")


@pytest.mark.parametrize(("nodes", "beams"), [(FORK, BEAMS), (DIAMOND, ROUND)], ids=["fork", "ring"])
def test_one_frame_per_element_is_the_corotational_frame(tmp_path, nodes, beams):
    """Places of the ends and the stress, to what both solvers leave; the ring's ends are tied to each other where it is clamped."""
    save_frame(tmp_path, nodes, beams, 3)
    count = 3 * len(beams)
    found = ffrf.compile(scene_of(tmp_path, count)).statics()
    mesh = load(tmp_path / "frame.h5").mesh
    assert mesh is not None
    judge = corotational(mesh.nodes, mesh.connectivity, 1e9, 0.01, 0.02)
    loads = np.zeros(3 * len(mesh.nodes))
    loads[6:8], loads[9:11] = (0.5, 2.0), (0.5, 1.0)  # nodes C and D
    u = solve_corotational(judge, loads, np.eye(3, len(loads)))
    assert np.abs(u).max() > 0.05
    assert [found.values[name] for name in ("x", "y", "low")] == pytest.approx(u[[6, 7, 10]], abs=1e-9)  # statics end at 1e-10
    assert found.values["stress"] == pytest.approx(np.abs(judge.stress(u, points_of(count))).max(), rel=1e-6)  # E times that


def test_reduced_members_bend_as_all_their_coordinates_do(tmp_path):
    """Without a mode, because forces act where points are; gradients too, by a thickness and by the place where all members meet."""
    save_frame(tmp_path, FORK, BEAMS, 6)
    full, few = (
        ffrf.compile(scene_of(tmp_path, 4, body=f'frame = "grounded", {words}'), variables=["t", "x"]).statics(gradients=True)
        for words in ("", "modes_per_frame = 0, ")
    )
    assert few.solution.q.shape[1] < full.solution.q.shape[1] / 1.5
    for response, value in full.values.items():
        assert few.values[response] == pytest.approx(value, rel=1e-9)  # statics end at 1e-10 of the size
        for name, slope in full.gradients[response].items():
            assert few.gradients[response][name] == pytest.approx(slope, rel=1e-8)


def test_it_bends_in_space_as_in_the_plane(tmp_path):
    values = {}
    for dimension in (2, 3):
        folder = tmp_path / str(dimension)
        folder.mkdir()
        save_frame(folder, FORK, BEAMS, 2, dimension)
        model = ffrf.compile(scene_of(folder, 5, dimension), variables=["t", "x"])
        values[dimension] = model.statics().values
    agree(model, "statics")
    for name, value in values[2].items():
        assert values[3][name] == pytest.approx(value, rel=1e-7), name  # both end at 1e-10 of the size, stress is E times that


SWING = """[joints]
hub = { type = "spherical", bodies = ["fork", "ground"], point = "root" }
[solver]
end_time = 0.006
step = 0.002
rho_inf = 0.8
"""


def test_gradients_of_a_fork_that_swings_in_space_are_complex_steps(tmp_path):
    """By the place of the node where three parts meet, which turns all their chords."""
    save_frame(tmp_path, FORK, BEAMS, 1, 3)
    scene = scene_of(tmp_path, 3, 3, "angular_velocity = [0.3, 0.5, 1.5], ", SWING)
    agree(ffrf.compile(scene, variables=["t", "x"]), "simulate")


@pytest.fixture(scope="module")
def fork(tmp_path_factory):
    """Of three elements in each member."""
    folder = tmp_path_factory.mktemp("fork")
    save_frame(folder, FORK, BEAMS, 3)
    return folder


def test_more_frames_go_where_elements_share_one(fork):
    """One to every member first; a named node is cut besides the joint."""
    for frames, cuts in (
        (3, (0, 3, 6, 9)),
        (4, (0, 2, 3, 6, 9)),
        (5, (0, 2, 3, 5, 6, 9)),
        ('["joint"]', (0, 3, 6, 9)),
        ("[]", (0, 3, 6, 9)),
    ):
        cut = resolve(scene_of(fork, frames))
        assert cut.bodies["fork"].cuts == cuts
    assert list(resolve(scene_of(fork, 3)).joints) == ["fork at node 1", "fork at node 1, 2", "fork at node 0"]


def test_its_picture_has_no_steps(fork):
    """Elements as drawn meet at the joint of the three members."""
    solution = ffrf.compile(scene_of(fork, 3)).statics().solution
    shape = skin_shape(Configuration(solution, 0), "fork")
    assert shape is not None
    ends = [shape.line[2, -1], shape.line[3, 0], shape.line[8, -1]]
    np.testing.assert_allclose(ends, [ends[0]] * 3, atol=1e-9)  # the ties close to 1e-10 of the size


def test_a_number_is_chosen_for_what_branches(fork):
    """Every member has a frame at least; the error that is seen against a frame to every element is the one that is wanted."""
    run = ffrf.compile(scene_of(fork, '"auto", geometric_error = 0.02')).statics()
    said = run.verdict.measures["frames"]["fork"]
    assert said["tried"] == [1, 4, 8]
    exact = ffrf.compile(scene_of(fork, 9)).statics().solution
    true = largest_distance(node_places(run.solution, "fork"), node_places(exact, "fork")) / largest_displacement(exact, "fork")
    assert true < said["estimated_error"] < 0.02
    assert read_axes(scene_of(fork, 3), "frames")["frames"][-1].label == "every"
    with pytest.raises(InputError, match="give 1, or whole numbers from 3 to 9, the elements of the body, or every"):
        read_axes(scene_of(fork, 3), "frames=2")


def test_a_fork_is_judged_by_the_whole_mechanism_and_by_twice_the_frames(fork):
    run = ffrf.compile(scene_of(fork, 3), variables=["t"]).statics(gradients=True)
    found = compare_mechanism(run.solution, ["t"])
    assert found is not None
    assert found.corotational is not None
    exact = found.corotational.gradients["y"]["t"]
    assert found.quotients["y"]["t"] == pytest.approx(exact, rel=1e-5)  # truncation of the quotient
    said = run.verdict.measures["geometric_error"]
    assert said["how"] == "the same run with 6 frames instead of 3 in fork"
    assert said["gradients"]["y"]["t"] == pytest.approx(exact - run.gradients["y"]["t"], rel=0.5)


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        (2, "they are 3 chains, and each needs a frame. Write at least 3"),
        (10, "has 9 elements, and a frame needs one at least"),
        ("[3]", "so that nodes have no numbers along them. Name interface points"),
        ('["tip"]', "cuts at node 2, where an end of the body is already"),
    ],
)
def test_cuts_that_cannot_be_are_refused(fork, frames, words):
    with pytest.raises(InputError, match=words.replace("[", r"\[")):
        compile_scene(scene_of(fork, frames))
