"""What a file stores and what a message names is the same on every processor; see `processors`."""

from __future__ import annotations

import numpy as np
import pytest

from preprocessing.builders.build_model import build
from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from tests.models.processors import BUILT, MODELS, entries, kernels, rotating_beam, under
from tests.preprocessing.test_preprocess_cli import arrays
from toolkit.analyses.modes import solve_modes
from toolkit.analyses.sensitivity.direct import direct
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.bodies.rigid import Rigid, Rod
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rigid_joint import RigidJoint
from toolkit.components.loads.gravity import Gravity
from toolkit.components.loads.torque import Torque
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.near_ties import first_largest, first_smallest
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.shapes import entry_scales
from toolkit.responses.stress import MaxStress
from toolkit.scene.scene import Scene
from toolkit.system.redundant_rows import independent_rows
from toolkit.system.system import compile_scene

STEEL = Section(youngs_modulus=210e9, density=7800.0, thickness=0.02, width=0.05)


@pytest.mark.robustness
def test_models_hold_the_same_entries_under_every_kernel():
    """And each process has the kernel that was asked for."""
    assert len(kernels()) == 3
    used, *found = zip(*(under(kernel, "entries").split("\n", 1) for kernel in kernels()), strict=True)
    assert list(used) == kernels()
    found = [lines.splitlines() for lines in found[0]]
    assert len(found[0]) > 100
    for other in found[1:]:
        assert [line for line, again in zip(found[0], other, strict=True) if line != again] == []


@pytest.mark.processors
@pytest.mark.parametrize("name", [*BUILT, "rotating_beam/beam"])
def test_committed_models_are_what_their_inputs_give(name):
    committed = load(MODELS / f"{name}.h5")
    fresh = build(BUILT[name].with_suffix(".toml")) if name in BUILT else rotating_beam()
    assert committed.input_hash == fresh.input_hash
    assert (committed.nominal, committed.inputs, committed.source) == (fresh.nominal, fresh.inputs, fresh.source)
    ours, theirs = dict(entries(committed)), dict(entries(fresh))
    assert ours.keys() == theirs.keys()
    for item, numbers in ours.items():
        assert np.array_equal(numbers, theirs[item]), item
    for item, value in arrays(committed).items():
        # kernels round differently, and the splines amplify that a little, the modes of a solid by the condition of its stiffness
        np.testing.assert_allclose(arrays(fresh)[item], value, rtol=0, atol=1e-9 * np.abs(value).max(initial=0), err_msg=item)


def test_no_entry_of_a_full_basis_is_round_off():
    """The wing's first moment has 54 entries between 1e-22 and 1e-17 of the largest if nobody looks; each is 0 = L/2 cs - L/2 cs."""
    model = load(BUILT["morphing_wing/skin"].with_suffix(".h5"))
    for item, scale in entry_scales(model.invariants).items():
        parts = np.abs(getattr(model.invariants, item)) / np.where(scale > 0, scale, 1)
        assert not np.any((parts > 0) & (parts < 1e-9)), item
    first_moment = model.invariants.first_moment
    assert np.all(first_moment[0, 2::3] == 0)  # an x-displacement needs no force in y: columns 1, 2, 3 are x, y and rotation
    assert np.all(first_moment[1, 1::3] == 0)


def test_what_a_held_point_does_has_no_derivative_of_round_off():
    """The displacements of M are coordinates, and its rotation is none of the section or material."""
    derivatives = load(BUILT["flexible_slider_crank/frame"].with_suffix(".h5")).derivatives
    assert "interfaces.M.rotation" not in derivatives
    assert len(set(derivatives["interfaces.M.position"].parameter)) < len(set(derivatives["stiffness"].parameter))


@pytest.mark.processors
@pytest.mark.parametrize("turned", [0.0, 0.9272952180016122])
@pytest.mark.parametrize("count", [1, 2, 4, 6, 8])
def test_free_modes_of_straight_beams_are_models_like_others(count, turned, tmp_path):
    """Bending alone couples no displacements along and across the beam: H, of which round-off is left, is antisymmetric none the less."""
    along = np.linspace(-0.5, 0.5, 17)
    nodes = np.column_stack([np.cos(turned) * along, np.sin(turned) * along])
    model = polygon_beam(nodes, STEEL, {"left": 0.0, "right": 1.0}, basis=BasisChoice("eigenmodes", boundary="free", count=count))
    save(model, tmp_path / "beam.h5")
    read = load(tmp_path / "beam.h5")
    assert read.n_f == count
    coupling = np.abs(read.invariants.gyroscopic / entry_scales(read.invariants)["gyroscopic"])
    if count <= 6:  # the seventh is the first one that stretches
        assert coupling.max() < 1e-9
    assert np.array_equal(read.invariants.gyroscopic, -read.invariants.gyroscopic.T)


def test_a_model_that_is_not_symmetric_beyond_round_off_is_still_refused(tmp_path):
    model = polygon_beam(np.column_stack([np.linspace(0, 1, 5), np.zeros(5)]), STEEL, {"left": 0.0})
    for name, size in (("inertia", 1e-6), ("gyroscopic", 1e-6), ("stiffness", 1e-5)):
        array = getattr(model.invariants, name).copy()
        array[2, 1] += size * entry_scales(model.invariants)[name][2, 1]
        array[1, 2] += 0.5 * size * entry_scales(model.invariants)[name][2, 1]
        wrong = type(model.invariants)(**{**vars(model.invariants), name: array})
        with pytest.raises(Exception, match=rf"invariants/{name} is not (anti)?symmetric"):
            save(type(model)(**{**vars(model), "invariants": wrong, "affine": {}}), tmp_path / "beam.h5")


@pytest.mark.processors
def test_of_near_ties_the_first_is_named():
    rng = np.random.default_rng(3)
    for _ in range(100):
        sizes = np.array([0.5, 1.0, 0.2, 1.0, 1.0]) * (1 + 1e-13 * rng.normal(size=5))
        assert first_largest(sizes) == 1
        assert first_largest(-sizes) == 2
        assert first_smallest(sizes - sizes.min()) == 2
    assert first_largest(np.array([1.0, np.nan, 2.0])) == 1
    assert first_largest(np.array([1.0, 1.0 + 1e-5])) == 1


@pytest.mark.processors
def test_of_joints_that_repeat_each_other_the_later_ones_are_left_out():
    """All rows are equally long, so that only their last digits differ: one kind of pivoting would follow these."""
    rng = np.random.default_rng(0)
    rows = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 1, 1], [1, 1, 0, 0]])
    for _ in range(50):
        found = independent_rows(rows * (1 + 1e-15 * rng.normal(size=rows.shape)), np.ones(4), np.zeros(0, int))
        assert (found.kept.tolist(), found.repeating.tolist(), found.almost.tolist()) == ([0, 1, 4], [2, 3, 5, 6], [])


@pytest.mark.processors
@pytest.mark.parametrize("y", [0.1, 0.13, 0.23, 0.4, 0.63, 0.93])
def test_a_balance_has_the_frequency_zero(y):
    """m g x - m g x is no stiffness, and none that is negative: what is left of it is round-off of the joint forces times their levers."""
    points = {"O": Point(x=0.0, y=0.0), "A": Point(x=0.3 + y / 7, y=y), "B": Point(x=-0.3 - y / 7, y=-y)}
    ends = {name: Rigid(mass=3.1, inertia=0.01, center=name) for name in "AB"}
    scene = Scene(
        units="m-kg-s",
        points=points,
        bodies={"arm": Rod(between=("A", "B"), area=1e-3, density=7800.0), **ends},
        joints={
            "O": Revolute(bodies=("arm", "ground"), point="O"),
            **{name: RigidJoint(bodies=("arm", name), point=name) for name in "AB"},
        },
        loads={"weight": Gravity(acceleration=(0.0, -9.81))},
        solver=RunOptions(end_time=0.01, step=0.01),
    )
    assert solve_modes(simulate(compile_scene(scene))).frequencies.tolist() == [0.0]


@pytest.mark.processors
@pytest.mark.parametrize("n_elements", [4, 5, 7, 9])
def test_of_points_of_equal_stress_the_first_is_the_largest(n_elements, tmp_path):
    """A moment at the tip bends all elements alike; the maximum has the derivative of the first one, and of no other.

    sigma = 6 M / (b t^2), so that d sigma / d t_0 = -2 sigma / t.
    """
    nodes = np.column_stack([np.linspace(0, 1, n_elements + 1), np.zeros(n_elements + 1)])
    save(polygon_beam(nodes, STEEL, {"tip": 1.0}, separate=("thickness",)), tmp_path / "beam.h5")
    scene = Scene(
        units="m-kg-s",
        points={"T": BodyPoint(body="beam", interface="tip")},
        bodies={"beam": Flexible(model="beam.h5", frame="grounded")},
        loads={"moment": Torque(body="beam", point="T", torque=10.0)},
        responses={"stress": MaxStress(body="beam", measure="absolute")},
        directory=tmp_path,
    )
    found = direct(scene, [f"bodies.beam.thickness_{k}" for k in range(n_elements)], "static")
    stress = 6 * 10.0 / (STEEL.width * STEEL.thickness**2)
    assert found.values["stress"] == pytest.approx(stress, rel=1e-8)  # condition of a thin beam's stiffness
    first, *others = found.gradients["stress"].values()
    assert first == pytest.approx(-2 * stress / STEEL.thickness, rel=1e-8)
    assert np.abs(others).max() < 1e-8 * abs(first)
