"""Forces of inertia bend elements between their nodes as weight does: shaken, swung, falling, in the plane and in space."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import ffrf
from preprocessing.reduction.basis import BasisChoice
from tests.models.spatial_chains import chain_scene, save_chain
from tests.validity.test_beam_assumptions import RHO, cantilever, shares
from toolkit.system.solution import Solution, poses_at
from toolkit.system.system import compile_scene
from toolkit.validity.bodies import beam_assumptions
from toolkit.validity.bodies.beam_assumptions import pull_on_elements
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.bodies.known_chain import chain

TIMES, THICKNESS = 2.0, 0.02
CLAMP = """
[joints]
slide = { type = "slider", bodies = ["beam", "ground"], point = "R", axis = [0.0, 1.0], lock_rotation = true }
drive = { type = "position-driver", bodies = ["beam", "ground"], point = "R", axis = [0.0, 1.0], curve = CURVE }
"""
HINGE = """
[joints]
hinge = { type = "revolute", bodies = ["beam", "ground"], point = "R" }
drive = { type = "angle-driver", bodies = ["beam", "ground"], point = "R", curve = CURVE }
"""


def moved(folder, elements: int, joints: str, weight: str = "0.0", frames: int = 1, solver: str = "", **basis: Any):
    """A motion of two seconds that the joints lead; the point R is the clamped end."""
    scene = cantilever(folder, elements, frames=frames, **basis)
    text = (folder / "scene.toml").read_text().replace('frame = "grounded"', 'frame = "moving"').replace("-9.81", weight)
    text = text.replace("[bodies.beam]", 'R = { body = "beam", interface = "root" }\n[bodies.beam]') + "\n" + joints
    text += f"\n[solver]\nend_time = {TIMES}\nstep = 0.02\nrho_inf = 0.5\n{solver}\n"
    (scene.directory / "scene.toml").write_text(text)
    return ffrf.compile(ffrf.read_scene(scene.directory / "scene.toml")).simulate()


@pytest.mark.parametrize(
    ("elements", "frames", "basis"),
    [(1, 1, None), (2, 1, None), (2, 2, None), (8, 1, BasisChoice("craig-bampton", count=0))],
    ids=["one element", "two", "two with frames", "no modes"],
)
def test_stress_that_shaking_adds_between_nodes_is_said_as_large_as_it_is(elements, frames, basis, tmp_path):
    """The clamp rises by a cycloid, so that its acceleration a = 2 pi h sin / T^2 acts as a weight does."""
    rise = CLAMP.replace("CURVE", f'{{ type = "cycloid", height = 1.0, duration = {TIMES} }}')
    run = moved(tmp_path, elements, rise, frames=frames, **({} if basis is None else {"basis": basis}))
    exact = RHO * (2 * np.pi / TIMES**2) / 2 * THICKNESS / 2 / (THICKNESS**2 / 12)
    part = 1 - run.values["stress"] / exact
    assert shares(run) == ([pytest.approx(part, abs=0.01)] if part > LIMIT else [])  # of a clamp that rings by 1 %
    assert run.verdict.trusted == (part < LIMIT)


def test_stress_of_a_bar_that_swings_faster_and_faster_is_said(tmp_path):
    """Its acceleration grows from the hinge, so that the one in the middle of its element tells some more than it lacks."""
    turn = HINGE.replace("CURVE", f'{{ type = "cycloid", height = 1.0, duration = {TIMES} }}')
    run = moved(tmp_path, 1, turn)
    exact = RHO * (2 * np.pi / TIMES**2) / 3 * THICKNESS / 2 / (THICKNESS**2 / 12)
    (found,) = shares(run)
    assert 0 < found - (1 - run.values["stress"] / exact) < 0.03


def test_stress_that_damping_of_the_mass_adds_between_nodes_is_said_as_large_as_it_is(tmp_path):
    """The clamp rises by a cycloid, whose largest speed is 2 h / T: so much times the damping acts as a weight does."""
    rise = CLAMP.replace("CURVE", f'{{ type = "cycloid", height = 1.0, duration = {TIMES} }}')
    run = moved(tmp_path, 1, rise, drag=100.0)
    exact = RHO * 100.0 * (2 / TIMES) / 2 * THICKNESS / 2 / (THICKNESS**2 / 12)
    assert shares(run) == [pytest.approx(1 - run.values["stress"] / exact, abs=0.01)]


@pytest.mark.parametrize("frames", [1, 2])
def test_a_beam_that_falls_freely_lacks_nothing(frames, tmp_path):
    """Nothing bends it; what is left of weight and inertia is round-off."""
    assert not shares(moved(tmp_path, 2, "", "-9.81", frames=frames))


def test_without_inertia_weight_alone_is_looked_at(tmp_path):
    rise = CLAMP.replace("CURVE", f'{{ type = "cycloid", height = 1.0, duration = {TIMES} }}')
    assert not shares(moved(tmp_path, 1, rise, solver="quasi_static = true"))


FRAMES = {
    "grounded": 'frame = "grounded"',
    "translating": 'frame = "translating"',
    "turning": 'frame = "turning", axis = [0.2, 1.0, 0.3]',
    "moving": "",
}


@pytest.fixture(scope="module")
def crooked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("crooked")
    save_chain(folder, np.array([[0.0, 0.0, 0.0], [0.4, 0.1, 0.0], [0.7, 0.4, 0.3]]))
    return folder


@pytest.mark.parametrize("frame", FRAMES)
def test_accelerations_of_elements_in_space_are_second_differences_of_their_places(frame, crooked):
    """Along a motion q + v t + a t^2 / 2 whose quaternion keeps its length to second order."""
    weight = '[loads]\ng = { type = "gravity", acceleration = [0.5, -2.0, 1.0] }\n'
    weight += 'f = { type = "point-force", body = "beam", point = "tip", force = [1.0, 0.0, 0.0] }\n'
    scene = chain_scene(crooked, ", ".join(filter(None, [FRAMES[frame], "orientation = [0.3, 0.2, 0.1]"])), weight)
    system, rng = compile_scene(scene), np.random.default_rng(5)
    q, v, a = (0.3 * rng.normal(size=system.n_q) for _ in range(3))
    if frame == "moving":
        p = slice(3, 7)
        q[p] /= np.linalg.norm(q[p])
        v[p] -= q[p] * (q[p] @ v[p])
        a[p] -= q[p] * (q[p] @ a[p] + v[p] @ v[p])

    def states(*each: np.ndarray) -> Solution:
        rows = [np.tile(x, (2, 1)) for x in each]
        none = np.zeros((2, 0, 0))
        return Solution(system, np.array([0.0, 1.0]), *rows, np.zeros((2, 0)), none, none, none, none, options=scene.solver)

    def middles(t: float) -> np.ndarray:
        at = (q + v * t + a * t * t / 2)[None]
        behind = chain(system.scene, "beam")
        sides = beam_assumptions.sides_of(behind)
        body = scene.bodies["beam"]
        origin, axes = body.poses(at)
        own = beam_assumptions.middles(behind, sides, behind.displacements(at[:, body.frame_size :]))
        return origin + (behind.nodes[sides.ends].mean(axis=1) + own[0]) @ axes[0].T

    h = 1e-3
    expected = np.array([0.5, -2.0, 1.0]) - (middles(h) - 2 * middles(0.0) + middles(-h)) / h**2
    axes = scene.bodies["beam"].poses(q[None])[1][0]
    behind, body = chain(system.scene, "beam"), scene.bodies["beam"]
    tip = behind.nodes[-1] + behind.by_node(behind.displacements(q[None, body.frame_size :]))[0][0, -1]
    ends = poses_at(system, [q])[0, :, :3]  # of all markers, as the solver has them
    assert np.abs(ends - body.poses(q[None])[0][0] - axes @ tip).max(axis=1).min() < 1e-12
    found = pull_on_elements(states(q, v, a), "beam", chain(system.scene, "beam"), np.array([0]))[0]
    np.testing.assert_allclose(found @ axes.T, expected, atol=1e-5)  # h^2 of fourth derivatives
