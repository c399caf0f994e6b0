"""Second-order deformation of beams in space: against the exact energy of elements that turn, against struts, strings and more frames."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ffrf
from tests.models.spatial_beams import Beams, crooked
from tests.models.spatial_chains import WHERE, chain_scene, save_chain
from toolkit.validity.bodies.chain import Forms, second_order_forces, stiffness_matrix
from toolkit.validity.bodies.deformation import LIMIT, deformation, largest_displacement, largest_distance, node_places
from toolkit.validity.bodies.known_chain import spatial_forms

LENGTH, THICKNESS, WIDTH, YOUNG, RATIO, ELEMENTS = 1.0, 0.01, 0.02, 1e9, 0.3, 16
SOFT, STIFF = (YOUNG * a * b**3 / 12 for a, b in ((WIDTH, THICKNESS), (THICKNESS, WIDTH)))
EULER = np.pi**2 * SOFT / (4 * LENGTH**2)
SIDE = 3e-3 * EULER
"""Of a force across the beam that bends it by 0.2 % of its length: nothing but the axial force counts."""


@pytest.fixture(scope="module")
def forms() -> tuple[Beams, Forms]:
    """Three elements in all directions that meet."""
    beams = crooked(np.random.default_rng(0))
    stiffness = _blocks(beams)
    return beams, spatial_forms(beams.nodes, beams.connectivity, stiffness)


def _blocks(beams: Beams) -> np.ndarray:
    """Stiffness of every element, by that of each alone."""
    found = []
    for k in range(len(beams.connectivity)):
        alone = Beams(beams.nodes[beams.connectivity[k]], np.array([[0, 1]]), beams.orientation[[k]])
        found.append(alone.dense("stiffness"))
    return np.array(found)


def test_the_stiffness_of_the_forms_is_that_of_the_elements(forms):
    beams, found = forms
    exact = beams.dense("stiffness")
    assert np.abs(stiffness_matrix(found) - exact).max() < 1e-14 * np.abs(exact).max()


def _energy(beams: Beams, forms: Forms, u: np.ndarray) -> float:
    """Of elements that turn with their chords and roll so that both ends roll against them by opposite angles, exactly."""
    moved, found = u.reshape(-1, 6), 0.0
    for k, (i, j) in enumerate(beams.connectivity):
        before = beams.nodes[j] - beams.nodes[i]
        after = before + moved[j, :3] - moved[i, :3]
        e, t = (side / np.linalg.norm(side) for side in (before, after))
        axis = np.cross(e, t)
        turn = Rotation.from_rotvec(axis / np.linalg.norm(axis) * np.arctan2(np.linalg.norm(axis), e @ t))
        roll = 0.0
        for _ in range(20):
            axes = turn * Rotation.from_rotvec(roll * e)
            ends = [(axes.inv() * Rotation.from_rotvec(moved[n, 3:])).as_rotvec() for n in (i, j)]
            roll += e @ (ends[0] + ends[1]) / 2
        d = np.concatenate([[np.linalg.norm(after) - np.linalg.norm(before)], *ends])
        found += d @ forms.law[k] @ d / 2
    return found


def test_the_forces_of_second_order_are_those_of_the_exact_energy(forms):
    """What of the energy changes its sign with the displacement is of third order, and next of fifth."""
    beams, found = forms
    u, w = np.random.default_rng(1).normal(size=(2, 6 * len(beams.nodes)))
    third = second_order_forces(found, u[None])[0]

    def odd(size: float, of: np.ndarray) -> float:
        return (_energy(beams, found, size * of) - _energy(beams, found, -size * of)) / (2 * size**3)

    def slope(size: float) -> float:
        return (odd(size, u + 1e-3 * w) - odd(size, u - 1e-3 * w)) / 2e-3

    for exact, of in ((third @ u / 3, lambda size: odd(size, u)), (third @ w, slope)):
        one, other = (of(size) - exact for size in (0.02, 0.01))
        assert abs(other) < 0.01 * abs(exact)
        assert one / other == pytest.approx(4.0, rel=0.05)  # of order two


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A straight cantilever along x, whose thinner side is y."""
    found = tmp_path_factory.mktemp("strut")
    section = f'kind = "rectangle", thickness = {THICKNESS}, width = {WIDTH}'
    save_chain(found, np.linspace([0.0, 0, 0], [LENGTH, 0, 0], ELEMENTS + 1), section, YOUNG, RATIO)
    return found


def loaded(folder, force, frames=1, torque=(0.0, 0.0, 0.0)):
    loads = f"""[loads]
push = {{ type = "point-force", body = "beam", point = "tip", force = {[float(f) for f in force]} }}
turn = {{ type = "torque", body = "beam", point = "tip", torque = {[float(t) for t in torque]} }}
[responses]
"""
    return ffrf.compile(chain_scene(folder, f'frame = "grounded", frames = {frames}', loads + WHERE)).statics()


def true_error(folder, run, *load, **keys) -> float:
    """Against a frame to every element, in parts of the displacement of the run."""
    exact = loaded(folder, *load, frames=ELEMENTS, **keys)
    apart = largest_distance(node_places(run.solution, "beam"), node_places(exact.solution, "beam"))
    return apart / largest_displacement(run.solution, "beam")


def of_strut(part: float) -> float:
    """By how much an axial force, in parts of Euler's load and positive in compression, makes the tip of a cantilever yield more."""
    u = np.pi / 2 * np.sqrt(complex(part))
    return float(np.real(3 * (np.tan(u) - u) / u**3 - 1))


@pytest.mark.parametrize("part", [0.05, 0.2, -0.2])
@pytest.mark.parametrize(("axis", "stiffness"), [(1, SOFT), (2, STIFF)])
def test_axial_forces_are_in_the_estimate(folder, part, axis, stiffness):
    force = np.array([-part * EULER, 0.0, 0.0])
    force[axis] = SIDE
    run = loaded(folder, force)
    found, own = deformation(run.solution, "beam"), part * SOFT / stiffness
    assert found.relative == pytest.approx(abs(of_strut(own)), rel=1.5 * abs(own) + 0.02)  # without what is of order own^2
    assert found.relative == pytest.approx(true_error(folder, run, force), rel=1.5 * abs(own) + 0.02)
    assert ("large-deformation" in run.verdict.codes) == (found.relative > LIMIT)


def test_a_string_is_far_off_and_not_trusted(folder):
    """Ten times EI / L^2 makes a fifth of the deflection, which one linear frame does not know."""
    force = [10 * SOFT / LENGTH**2, SIDE, 0.0]
    run = loaded(folder, force)
    u = np.sqrt(10)
    exact = 3 * (1 - np.tanh(u) / u) / u**2
    linear = run.values["y"] / exact / (SIDE * LENGTH**3 / (3 * SOFT))
    assert linear * exact == pytest.approx(1.0, rel=1e-6)
    assert linear - 1 > 3.0
    assert deformation(run.solution, "beam").relative == pytest.approx(
        10 * 2 / 5, rel=0.05
    )  # the first term of the series of 1 / exact
    assert not run.verdict.trusted
    assert loaded(folder, force, frames=8).verdict.trusted


def test_twist_and_bending_together_are_in_the_estimate(folder):
    """The deflection of a bar that a torque twists goes out of its plane: the meter feels it as more frames do."""
    torque = (0.12, 0.0, 0.0)
    for force in ([0.0, 0.02, 0.0], [0.0, 0.0, 0.05]):
        run = loaded(folder, force, torque=torque)
        found = deformation(run.solution, "beam").relative
        assert found == pytest.approx(true_error(folder, run, force, torque=torque), rel=0.1)
        assert found > 0.01


def test_pure_twist_of_one_frame_and_of_several_is_exact(folder):
    for frames in (1, 4):
        run = loaded(folder, [0.0, 0.0, 0.0], frames=frames, torque=(0.5, 0.0, 0.0))
        assert deformation(run.solution, "beam").error < 1e-12 * LENGTH
        assert run.verdict.codes == ()


def test_frames_in_number_leave_a_part_that_is_estimated(folder):
    force = [-0.2 * EULER, 0.05, 0.08]
    of = {}
    for frames in (1, 2, 4):
        run = loaded(folder, force, frames=frames)
        of[frames] = deformation(run.solution, "beam").relative
        assert of[frames] == pytest.approx(true_error(folder, run, force), rel=0.5)
    assert of[4] < of[2] / 3 < of[1] / 6
