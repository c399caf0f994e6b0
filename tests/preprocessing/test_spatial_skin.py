"""The skin in space: in its plane it is the planar skin to round-off, across it a wide strip, and its design derivatives are exact."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders.skin_geometry import read_geometry
from preprocessing.builders.skin_recipe import SkinRecipe, design_space
from preprocessing.reduction.chosen_basis import tangent_frame
from preprocessing.reduction.invariants import contract_at
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.dependence import scattered
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.parts import SpatialInvariants, all_second_moments

SKIN = Path(__file__).parents[2] / "models" / "morphing_wing" / "skin.toml"
NAMES = [field.name for field in fields(SpatialInvariants)]
OTHER = {
    "youngs_modulus": 6.1e4,
    "density": 2.2e-9,
    "thickness": 1.9,
    "width": 700.0,
    "damping_mass": 2.0,
    "damping_stiffness": 1e-4,
}


@cache
def skin(dimension: int, **basis: Any) -> ReducedModel:
    keys: dict[str, Any] = {"dimension": dimension, "damping.mass": 0.5, "damping.stiffness": 2e-5}
    return build(SKIN, keys={**keys, **({"basis": basis} if basis else {})})


def close(found, expected, tolerance):
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * np.abs(expected).max(initial=0))


def in_plane(n_f: int) -> np.ndarray:
    """Numbers of the elastic coordinates x, y and rotation about z of the full basis."""
    return np.flatnonzero(np.isin(np.arange(n_f) % 6, (0, 1, 5)))


def test_blocks_of_the_plane_are_those_of_the_planar_skin():
    planar, spatial = skin(2), skin(3)
    own = in_plane(spatial.n_f)
    z, Q = np.append(0, 1 + own), all_second_moments(spatial.invariants.second_moment)
    inv, flat = spatial.invariants, planar.invariants
    close(inv.mass, flat.mass, 1e-15)
    close(inv.first_moment[:2, z], flat.first_moment, 1e-14)
    close((Q[0, 0] + Q[1, 1])[np.ix_(z, z)], flat.inertia, 1e-14)
    close((Q[0, 1] - Q[1, 0])[np.ix_(z, z)], flat.gyroscopic, 1e-13)  # differences of terms ten times larger
    for name in ("stiffness", "damping"):
        close(getattr(inv, name)[np.ix_(own, own)], getattr(flat, name), 1e-14)


def test_the_plane_and_what_leaves_it_do_not_feel_each_other():
    """Of a motion in the plane and one out of it, also when the frame turns about z."""
    inv = skin(3).invariants
    own = in_plane(skin(3).n_f)
    others = np.setdiff1d(np.arange(skin(3).n_f), own)
    Q = all_second_moments(inv.second_moment)
    assert not np.any(inv.stiffness[np.ix_(own, others)])
    for matrix in (Q[0, 0] + Q[1, 1] + Q[2, 2], Q[0, 1] - Q[1, 0], Q[0, 0] + Q[1, 1]):
        assert np.abs(matrix[np.ix_(np.append(0, 1 + own), 1 + others)]).max() < 1e-14 * np.abs(matrix).max()  # round-off


def test_stress_at_both_corners_of_a_fibre_is_that_of_the_planar_fibre():
    planar, spatial = skin(2), skin(3)
    rows = spatial.invariants.stress_operator[:, 0, in_plane(spatial.n_f)].reshape(30, 2, 2, 2, -1)  # element, fibre, side, end
    expected = planar.invariants.stress_operator.reshape(30, 2, 2, -1).swapaxes(1, 2)  # element, fibre, end
    for side in (0, 1):
        close(rows[:, :, side], expected, 1e-14)
    points = {name: getattr(spatial.stress, name).reshape(30, 4, 2) for name in ("element", "end", "fibre")}
    assert points["fibre"][3].tolist() == [[1, 1], [1, 1], [-1, -1], [-1, -1]]
    assert np.array_equal(points["end"][3], [[0, 1]] * 4)


def test_interface_points_and_shape_are_those_of_the_planar_skin():
    planar, spatial = skin(2), skin(3)
    z = np.append(0, 1 + in_plane(spatial.n_f))
    assert list(spatial.interfaces) == list(planar.interfaces)
    for name, point in planar.interfaces.items():
        own = spatial.interfaces[name]
        assert own.arc_length == point.arc_length
        assert np.array_equal(own.position[:, :2][..., z], point.position)
        assert np.array_equal(own.rotation[:, 2][..., z], point.rotation)
    assert np.array_equal(spatial.shape.position[..., z], planar.shape.position)


def test_lines_of_the_surface_are_the_edges_of_the_strip_and_their_stress_is_their_stretch():
    """sigma = E times the relative change of length of a line, for a motion that stretches and bends every element evenly across it."""
    model, rng = skin(3), np.random.default_rng(1)
    surface, rest = model.surface, np.eye(1, 1 + model.n_f)[0]
    assert len(surface.position) == len(model.invariants.stress_operator)
    places = (surface.position @ rest)[surface.lines]
    np.testing.assert_allclose(np.abs(places[..., 2]), 500.0, rtol=1e-14)
    q = rng.normal(size=model.n_f) * 1e-3
    moved = (surface.position[..., 1:] @ q)[surface.lines]
    line = places[:, 1] - places[:, 0]
    stretch = ((moved[:, 1] - moved[:, 0]) * line).sum(axis=1) / (line**2).sum(axis=1)
    ends = (model.invariants.stress_operator[:, 0] @ q)[surface.lines]  # linear from end to end, so the mean counts
    # the axes at both ends of an element are equal, and so is the mean of a curvature and the difference of the ends' slopes
    np.testing.assert_allclose(ends.mean(axis=1), 7e4 * stretch, rtol=0, atol=1e-9 * np.abs(ends).max())


def test_modes_of_the_planar_skin_are_among_those_in_space():
    planar = np.diag(skin(2, kind="eigenmodes", count=2).invariants.stiffness)
    spatial = np.diag(skin(3, kind="eigenmodes", count=12).invariants.stiffness)
    for eigenvalue in planar:
        # the strip is 1e5 times stiffer across its plane than in it, which costs so many digits of the soft modes
        assert np.abs(spatial / eigenvalue - 1).min() < 1e-8


def test_basis_kinds_are_kept_by_the_file(tmp_path):
    for basis in (
        {"kind": "eigenmodes", "count": 6, "boundary": "free"},
        {"kind": "craig-bampton", "count": 2},
        {"kind": "eigenmodes", "count": 6, "derivative": "frozen"},
    ):
        model = skin(3, **basis)
        save(model, tmp_path / "skin.h5")
        read = load(tmp_path / "skin.h5")
        assert (read.dimension, read.n_f) == (3, 20 if basis["kind"] == "craig-bampton" else 6)
        assert read.surface.position.shape == (240, 3, 1 + read.n_f)


def test_polynomials_are_a_fresh_preprocessing_at_any_design():
    model = skin(3)
    fresh = build(SKIN, values=OTHER, keys={"dimension": 3})
    p = np.array(list(({**model.nominal, **OTHER}).values()))
    for name in NAMES:
        expected = getattr(fresh.invariants, name)
        close(model.affine[name](p, expected.size).reshape(expected.shape), expected, 1e-12)


@pytest.mark.parametrize("parameter", ["poisson_ratio", "chord", "y_scale"])
def test_derivatives_are_the_complex_step_of_all_invariants(parameter):
    keys: dict[str, Any] = {"dimension": 3}
    file = SkinRecipe.read(SKIN).at(keys=keys).file
    space = design_space(SKIN, file, {}, read_geometry(SKIN, file))
    stepped = space.discretise({**space.values, parameter: space.values[parameter] + 1e-30j})
    exact = contract_at(stepped.parts, space.values, tangent_frame(stepped.nodes, 0, "F").z)
    model = build(SKIN, keys=keys)
    for name in NAMES:
        expected = np.imag(getattr(exact, name)) / 1e-30
        entry, value = (
            model.derivatives[name].by(model.numbers[parameter]) if name in model.derivatives else (np.zeros(0, int), [])
        )
        close(scattered(entry, np.asarray(value, float), expected.size).reshape(expected.shape), expected, 1e-10)


def test_a_skin_in_space_needs_poissons_ratio(tmp_path):
    text = SKIN.read_text().replace("poisson_ratio = 0.35", "").replace('units = "mm-t-s"', 'units = "mm-t-s"\ndimension = 3')
    (tmp_path / "skin.toml").write_text(text)
    with pytest.raises(InputError, match=r"material\.poisson_ratio: a skin in space .* add it"):
        build(tmp_path / "skin.toml")


def test_a_skin_in_space_is_not_thicker_than_wide():
    with pytest.raises(
        InputError, match=r"section: a skin in space is at least as wide as it is thick, but thickness = 30 and width = 20"
    ):
        build(SKIN, keys={"dimension": 3}, values={"thickness": 30.0, "width": 20.0})
