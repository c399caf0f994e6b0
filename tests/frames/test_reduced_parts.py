"""Parts of cut beams reduced to Craig-Bampton shapes, against the same parts with all coordinates and the complex step."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import ffrf
from tests.frames.test_cut_bodies import ARC, SECTION, agree, cantilever, in_space
from tests.frames.test_cut_in_space import CROOKED, SPUN, SWING
from tests.models.beam_models import save_beam
from tests.models.spatial_chains import chain_scene, save_chain
from toolkit.analyses.modes import solve_modes, undeformed
from toolkit.foundation.errors import InputError
from toolkit.responses.stress import stress_field
from toolkit.responses.vibration import DampingRatio, Frequency
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.deformation import largest_displacement, node_places
from toolkit.validity.bodies.full_scene import changed_vibrations, raised_frequencies
from toolkit.validity.bodies.missed_statics import left_out_shapes

EI = SECTION.youngs_modulus * SECTION.width * SECTION.thickness**3 / 12
FINE = np.column_stack([np.linspace(0, 1, 25), np.zeros(25)])
ROUND = np.column_stack([np.sin(np.linspace(0, 2, 25)), 1 - np.cos(np.linspace(0, 2, 25))])


def reduced(scene: Scene, modes: int | None) -> Scene:
    """The scene with so many modes in each part of the beam."""
    body = scene.bodies["beam"].model_copy(update={"modes_per_frame": modes})
    return scene.model_copy(update={"bodies": {"beam": body}})


def same(found, wanted, rel: float) -> None:
    for name, value in wanted.items():
        assert found[name] == pytest.approx(value, rel=rel), name


@pytest.mark.parametrize("modes", [0, 2])
def test_forces_at_points_bend_reduced_parts_as_all_coordinates_do(tmp_path, modes):
    """An arc under forces at its tip and a point inside of an element, far bent, with its gradients and at another thickness."""
    scene = cantilever(tmp_path, ROUND, 3, in_space((0.2, 1.5 * EI)))
    load = scene.loads["pull"].model_copy(update={"point": "middle"})
    scene = scene.model_copy(update={"loads": {**scene.loads, "push": load}})
    models = [ffrf.compile(reduced(scene, each), variables=["t", "F", "turned"]) for each in (None, modes)]
    for numbers in ({}, {"t": 0.012}):
        full, few = (model.statics(numbers, gradients=True) for model in models)
        assert few.solution.q.shape[1] <= 3 * (3 + 3 + modes + 2) + 6 < full.solution.q.shape[1] / 1.5
        same(few.values, full.values, 1e-9)  # statics end at 1e-10 of the size
        for name, by in full.gradients.items():
            for x, slope in by.items():
                size = max(abs(each * models[0].variables[k]) for k, each in by.items()) / abs(models[0].variables[x])
                assert few.gradients[name][x] == pytest.approx(slope, rel=1e-8, abs=1e-9 * size), (name, x)


def test_weight_bends_reduced_parts_as_all_coordinates_do(tmp_path):
    """Without any mode, down to the stress inside of the parts; thickness and density scale the shapes, but do not change them."""
    scene = cantilever(tmp_path, FINE, 3, (0.0, 0.0))
    text = (tmp_path / "scene.toml").read_text()
    (tmp_path / "scene.toml").write_text(
        text.replace("[loads]", '[loads]\nweight = { type = "gravity", acceleration = [0.0, -9.81] }')
    )
    scene = ffrf.read_scene(tmp_path / "scene.toml")
    for numbers in ({}, {"t": 0.014}):
        full, few = (ffrf.compile(reduced(scene, modes)).statics(numbers) for modes in (None, 0))
        same(few.values, full.values, 1e-8)
        stress, wanted = (stress_field(each.solution, "beam")[0] for each in (few, full))
        np.testing.assert_allclose(stress, wanted, atol=1e-7 * np.abs(wanted).max())  # E times what statics leave
        assert left_out_shapes(few.solution)["beam"].stress < 1e-6


def test_gradients_of_reduced_parts_in_space_are_complex_steps(tmp_path):
    """By a thickness, a node between two parts, and the start: constraint modes follow the design."""
    nodes = np.concatenate([np.linspace(a, b, 2, endpoint=False) for a, b in pairwise(CROOKED)])
    save_chain(tmp_path, nodes, damping=1e-3)
    body = "frames = 2, modes_per_frame = 1, orientation = [0.1, 0.2, 0.3], angular_velocity = [0.3, 0.5, 1.5]"
    text = SWING.replace("z_N2", "z_N4").replace("end_time = 0.006", "end_time = 0.002")
    agree(ffrf.compile(chain_scene(tmp_path, body, text), variables=["t", "z", "omega", "turned"]), "simulate")


HANGING = """units = "m-kg-s"
[points]
hub = { body = "beam", interface = "hub" }
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frames = 2, angular_velocity = 1.5, angle = 0.2 }
[joints]
hub = { type = "revolute", bodies = ["beam", "ground"], point = "hub" }
[loads]
weight = { type = "gravity", acceleration = [0.0, -9.81] }
[design]
t = "bodies.beam.thickness"
omega = "bodies.beam.angular_velocity"
[responses]
y = { type = "displacement", body = "beam", point = "tip", component = "y" }
stress = { type = "ks-stress", body = "beam", aggregation = 10.0, reference_stress = 1e6 }
[solver]
end_time = 0.1
step = 0.0002
"""


@pytest.fixture(scope="module")
def hanging(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hanging")
    save_beam(folder / "beam.h5", FINE, SECTION, {"hub": 0.0, "tip": 1.0})
    (folder / "scene.toml").write_text(HANGING)
    return ffrf.read_scene(folder / "scene.toml")


def test_what_is_left_out_of_a_motion_is_told(hanging):
    """The meter against the motion with all coordinates: to a third for displacements, because errors of forces add up in time, to 5 % for
    stresses, which follow at once. Too few modes are a doubt."""
    full = ffrf.compile(hanging).simulate().solution
    places, stress = node_places(full, "beam"), stress_field(full, "beam")[0]
    for modes, doubted in ((0, True), (2, False)):
        run = ffrf.compile(reduced(hanging, modes)).simulate()
        told, few = left_out_shapes(run.solution)["beam"], run.solution
        away = np.linalg.norm(node_places(few, "beam") - places, axis=2).max() / largest_displacement(full, "beam")
        assert told.displacement < 1.05 * away < 1.4 * told.displacement
        off = np.abs(stress_field(few, "beam")[0] - stress).max() / np.abs(stress).max()
        assert told.stress == pytest.approx(off, rel=0.05)
        said = [each.text for each in run.warnings if each.code == "left-out-shapes"]
        assert bool(said) == doubted
        assert all(f"keep {modes} modes each" in each for each in said)
        assert run.verdict.measures["left_out_shapes"]["beam"]["stress"] == told.stress


def test_gradients_of_a_motion_of_reduced_parts_are_complex_steps(tmp_path):
    """An arc, whose constraint modes depend on the thickness."""
    save_beam(tmp_path / "beam.h5", ROUND[::3], SECTION, {"hub": 0.0, "tip": 1.9})
    more = """kinetic = { type = "kinetic-energy", body = "beam" }
strain = { type = "strain-energy", body = "beam" }
centre = { type = "centre-of-mass", component = "y" }
[solver]"""
    text = HANGING.replace("[solver]", more).replace("end_time = 0.1\nstep = 0.0002", "end_time = 0.003\nstep = 0.001")
    (tmp_path / "scene.toml").write_text(text)
    agree(ffrf.compile(reduced(ffrf.read_scene(tmp_path / "scene.toml"), 1), variables=["t", "omega"]), "simulate")


def test_frequencies_of_reduced_parts_come_from_above(hanging):
    """As those of any shapes that hold fewer motions, and fall to those of all coordinates."""
    exact, *others = (ffrf.compile(reduced(hanging, modes)).modes(count=7) for modes in (None, 0, 1, 4))
    errors = [found.frequencies[1:] / exact.frequencies[1:] - 1 for found in others]
    for coarse, fine in pairwise(errors):
        assert np.all(fine < coarse + 1e-9)
    assert all(each.min() > -1e-9 for each in errors)
    assert errors[-1].max() < 1e-3 < errors[0].max()


RICH = 3e-4
"""What the shapes that the judge itself leaves out change frequencies by at most."""


@pytest.mark.parametrize(("modes", "count"), [(0, 6), (1, 3), (4, 8)])
def test_how_much_too_high_frequencies_are_is_told(hanging, modes, count):
    """By their numbers, as those of all coordinates: of no modes the seventh is another one. Errors of 5 % are a doubt."""
    found, exact = (ffrf.compile(reduced(hanging, each)).modes(count=1 + count) for each in (modes, None))
    solution = ffrf.compile(reduced(hanging, modes)).statics().solution
    told = raised_frequencies(solution, found.frequencies)[1:]
    true = found.frequencies[1:] / exact.frequencies[1:] - 1
    assert 1e-3 < true.max() < (0.6 if modes == 0 else 0.03)
    np.testing.assert_allclose(told, true, atol=RICH)
    cautions = [each for each in found.verdict.warnings if each.code == "left-out-shapes"]
    assert [each.doubt for each in cautions] == [modes == 0] * bool(told.max() > 0.01)
    if modes == 1:
        (said,) = [each for each in ffrf.compile(reduced(hanging, 1)).modes(count=9).verdict.reasons if "too high" in each]
        assert "so that frequencies are too high, or missing: number 4 by about 2" in said


@pytest.mark.parametrize(("modes", "said"), [(4, ""), (1, "f4, z4"), (0, "f4, z4, f7, z7")])
def test_responses_of_vibrations_are_told_what_is_left_out_too(hanging, modes, said):
    """The parts by which they are off: number 7 of no modes is one that stretches, nearly exact by itself, where all coordinates have a
    slower one that bends."""
    numbers = (4, 7) if modes == 0 else (4,)
    asked = {f"{kind.kind[0].replace('d', 'z')}{k}": kind(number=k) for k in numbers for kind in (Frequency, DampingRatio)}
    scene = hanging.model_copy(update={"responses": asked})
    full, few = (ffrf.compile(reduced(scene, each)).statics() for each in (None, modes))
    told = changed_vibrations(few.solution)
    assert changed_vibrations(full.solution) == {}
    for name, value in few.values.items():
        assert told[name] == pytest.approx(value / full.values[name] - 1, abs=RICH)
    cautions = [each for each in few.verdict.warnings if each.code == "left-out-shapes" and "which changes" in each.text]
    assert [each.doubt for each in cautions] == [modes == 0] * bool(said)
    if said:
        assert all(f"{name} by about {told[name]:+.1%}" in cautions[0].text for name in said.split(", "))
    if modes == 0:
        assert told["f7"] > 0.4


def test_vibrations_with_twins_are_told_too_and_those_without_damping_have_no_part(tmp_path):
    """A square beam bends in two planes alike."""
    save_chain(
        tmp_path, np.column_stack([np.linspace(0, 1, 9), np.zeros((9, 2))]), 'kind = "rectangle", thickness = 0.01, width = 0.01'
    )
    asked = '[responses]\nf5 = { type = "frequency", number = 5 }\nf6 = { type = "frequency", number = 6 }\n'
    words = 'frame = "grounded", frames = 2'
    scenes = [
        chain_scene(tmp_path, words + more, asked + 'z5 = { type = "damping-ratio", number = 5 }\n')
        for more in ("", ", modes_per_frame = 0")
    ]
    full, few = (ffrf.compile(scene).statics() for scene in scenes)
    told = changed_vibrations(few.solution)
    assert set(told) == {"f5", "f6"}
    for name, part in told.items():
        assert 1e-3 < part == pytest.approx(few.values[name] / full.values[name] - 1, abs=RICH)


@pytest.mark.parametrize("words", ['equilibrium = "spinning"', "end_time = 0.02\nstep = 2e-4"])
def test_vibrations_about_a_spin_and_the_end_of_a_motion_are_told_too(tmp_path, words):
    """A beam that a driver turns, in steady state and as a motion that begins there."""
    save_chain(
        tmp_path, np.column_stack([np.linspace(0, 1, 17), np.zeros(17)]), 'kind = "rectangle", thickness = 0.01, width = 0.02'
    )
    turns = '{ type = "polynomial", coefficients = [0.0, 0.2] }'
    when = "" if "spinning" in words else ', when = "end"'
    asked = "".join(f'f{k} = {{ type = "frequency", number = {k}{when} }}\n' for k in (1, 5, 7))
    text = SPUN.replace("TURNS", turns).replace("AXIS", "")
    text = text.replace('first = { type = "frequency" }\n', asked).replace('equilibrium = "spinning"', words)
    body = "frames = 2, angular_velocity = 0.2"
    analysis = "statics" if "spinning" in words else "simulate"
    models = [ffrf.compile(chain_scene(tmp_path, body + more, text, 2)) for more in ("", ", modes_per_frame = 0")]
    full, few = (getattr(model, analysis)() for model in models)
    told = changed_vibrations(few.solution)
    for name, value in few.values.items():
        assert told[name] == pytest.approx(value / full.values[name] - 1, abs=RICH)
    assert told["f7"] > 0.05
    assert any("which changes" in each.text and each.doubt for each in few.verdict.warnings)
    if analysis == "statics":
        found = models[1].modes(count=7)
        assert raised_frequencies(few.solution, found.frequencies)[6] == pytest.approx(told["f7"], abs=1e-6)  # of the same roots
        assert any("too high, or missing" in each.text for each in found.verdict.warnings)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("words", ["", ", modes_per_frame = 0"])
def test_motions_that_nothing_holds_are_zero_and_counted_once(tmp_path, dimension, words):
    """Six in space, three in the plane, of responses as of modes: what round-off leaves of their double roots are no vibrations."""
    free = 3 * dimension - 3
    save_chain(tmp_path, np.column_stack([np.linspace(0, 1, 9), np.zeros((9, dimension - 1))]), damping=1e-4)
    asked = "".join(f'f{k} = {{ type = "frequency", number = {k}, when = "end" }}\n' for k in (1, free, free + 1, free + 2))
    asked += 'z = { type = "damping-ratio", when = "end" }\n'
    scene = chain_scene(
        tmp_path, f"frames = 2{words}", f"[responses]\n{asked}[solver]\nend_time = 0.01\nstep = 0.005\n", dimension
    )
    modes = solve_modes(undeformed(compile_scene(scene)), free + 2)
    run = ffrf.compile(scene).simulate()
    assert np.all(modes.frequencies[:free] == 0)
    assert run.values["f1"] == run.values[f"f{free}"] == 0
    for k in (free + 1, free + 2):
        assert run.values[f"f{k}"] == pytest.approx(modes.frequencies[k - 1], rel=1e-4)  # damped a little
    assert run.values["z"] == pytest.approx(
        1e-4 / 2 * 2 * np.pi * modes.frequencies[free], rel=1e-3
    )  # damping by stiffness alone
    told = changed_vibrations(run.solution)
    assert set(told) == ({f"f{free + 1}", f"f{free + 2}", "z"} if words else set())
    assert all(0 < part < 0.01 for part in told.values())


def test_what_a_spin_leaves_out_is_told(tmp_path):
    """Stretch and lag of a beam that spins: stress as the meter says, and gone with the shapes of weight, which the spin of a short part is
    nearly."""
    nodes = np.column_stack([np.linspace(0, 1, 9), np.zeros((9, 2))])
    save_chain(tmp_path, nodes, orientation=(0.0, 1.0, 0.0))
    turns = '{ type = "polynomial", coefficients = [0.0, 10.0] }'
    text = SPUN.replace("TURNS", turns).replace("AXIS", ", axis = [0.0, 0.0, 1.0]")
    runs = [ffrf.compile(chain_scene(tmp_path, f"frames = 2{words}", text)).statics() for words in ("", ", modes_per_frame = 0")]
    stress, few = (stress_field(run.solution, "beam")[0] for run in runs)
    told = left_out_shapes(runs[1].solution)["beam"].stress
    assert told == pytest.approx(np.abs(few - stress).max() / np.abs(stress).max(), rel=0.05)
    assert 1e-4 < told < 0.05


def test_pairs_of_modes_of_equal_frequency_are_kept_whole(tmp_path):
    """A square beam bends in two planes alike: one mode of a part brings the other with it, and names tell what coordinates are."""
    save_chain(
        tmp_path, np.column_stack([np.linspace(0, 1, 9), np.zeros((9, 2))]), 'kind = "rectangle", thickness = 0.01, width = 0.01'
    )
    system = compile_scene(chain_scene(tmp_path, "frames = 2, modes_per_frame = 1", ""))
    names = [name for name in system.numbering.names if "beam[2]" in name]
    assert [name.split(" of ")[0] for name in names[-6:-1]] == [  # the last one is the length of the quaternion
        "fixed-interface mode 1", "fixed-interface mode 2", *(f"shape {k} under uniform acceleration" for k in (1, 2, 3))
    ]  # fmt: skip


def test_shapes_that_modes_know_but_for_round_off_are_no_coordinates(tmp_path):
    """With one node between its ends a part bends under its weight as its first modes do: what is left of it would be noise, which
    other processors have otherwise; it stretches otherwise than they do."""
    save_chain(
        tmp_path, np.column_stack([np.linspace(0, 1, 5), np.zeros((5, 2))]), 'kind = "rectangle", thickness = 0.01, width = 0.01'
    )
    system = compile_scene(chain_scene(tmp_path, "frames = 2, modes_per_frame = 1", ""))
    names = [name for name in system.numbering.names if "beam[2]" in name]
    assert [name.split(" of ")[0] for name in names[-4:-1]] == [
        "fixed-interface mode 1", "fixed-interface mode 2", "shape 1 under uniform acceleration"
    ]  # fmt: skip


def test_a_part_without_so_many_coordinates_keeps_all(tmp_path):
    """So that one frame to every element is the corotational beam, whatever number of modes is written."""
    scene = cantilever(tmp_path, ARC, 6, in_space((0.0, EI)))
    full, few = (ffrf.compile(reduced(scene, modes)).statics() for modes in (None, 3))
    same(few.values, full.values, 1e-12)  # of the same equations
    assert left_out_shapes(few.solution)["beam"].stress == 0


def test_a_point_that_comes_to_lie_at_a_node_is_held_there(tmp_path):
    """Other numbers of a compiled scene move the point to the end of its element, so that other coordinates are kept."""
    scene = reduced(cantilever(tmp_path, FINE, 2, in_space((0.0, EI))), 0)
    point = scene.points["middle"].model_copy(update={"arc_length": 0.45})
    load = scene.loads["pull"].model_copy(update={"point": "middle"})
    scene = scene.model_copy(update={"points": {**scene.points, "middle": point}, "loads": {**scene.loads, "push": load}})
    found = []
    for modes in (0, None):
        model = ffrf.compile(reduced(scene, modes))
        model.statics()
        found.append(model.statics({"points.middle.arc_length": 11 / 24}))
    same(found[0].values, found[1].values, 1e-9)  # statics end at 1e-10 of the size


@pytest.mark.parametrize(("force", "one"), [(1e-3, True), (1.5, False)])
def test_one_frame_that_was_chosen_says_that_it_reduces_nothing(tmp_path, force, one):
    scene = cantilever(tmp_path, FINE, 2, in_space((0.0, force * EI)))
    body = scene.bodies["beam"].model_copy(update={"frames": "auto", "modes_per_frame": 2, "geometric_error": 0.05})
    run = ffrf.compile(scene.model_copy(update={"bodies": {"beam": body}})).statics()
    assert (run.verdict.measures["frames"]["beam"]["frames"] == 1) == one
    (said,) = [each.text for each in run.verdict.warnings if each.code == "frames"]
    assert ("modes_per_frame reduces nothing: leave it out, or write frames = []" in said) == one
    kept = ffrf.load(run.save(tmp_path / "run.h5"), models=tmp_path)
    same(kept.values, run.values, 1e-12)  # of the same states


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("modes_per_frame = 2", "`modes_per_frame` reduces the parts of a body with several `frames`; write these too"),
        ("frames = 2, modes_per_frame = -1", "greater than or equal to 0"),
        ("frames = 2, modes_per_frame = true", "valid integer"),
    ],
)
def test_what_cannot_be_meant_is_refused(tmp_path, words, message):
    save_beam(tmp_path / "beam.h5", ARC, SECTION, {"hub": 0.0, "tip": 1.0})
    (tmp_path / "scene.toml").write_text(HANGING.replace("frames = 2", words))
    with pytest.raises(InputError, match=message):
        ffrf.read_scene(tmp_path / "scene.toml")
