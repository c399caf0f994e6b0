"""Beams along a polygon: their mass properties are those of the rods they consist of, and wrong inputs are refused."""

from __future__ import annotations

import numpy as np
import pytest

from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from preprocessing.reduction.basis import BasisChoice
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.dependence import scattered
from toolkit.reduced_model.design_point import DesignPoint, rates_at
from toolkit.reduced_model.model import ReducedModel

SECTION = Section(youngs_modulus=2.0, density=3.0, thickness=0.1, width=0.5)
ELBOW = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])


def test_mass_centre_and_inertia_are_those_of_two_rods():
    inv = polygon_beam(ELBOW, SECTION, {}).invariants
    per_length = 3.0 * 0.1 * 0.5
    np.testing.assert_allclose(inv.mass, 3 * per_length, rtol=1e-14)  # round-off, here and below
    np.testing.assert_allclose(inv.first_moment[:, 0], per_length * np.array([2 * 1 + 1 * 2, 1 * 0.5]), rtol=1e-14)
    about_the_origin = per_length * (2**3 / 3 + 1 * (2**2 + 1**2 / 3) + 3 * 0.1**2 / 12)  # with that of the section
    np.testing.assert_allclose(inv.inertia[0, 0], about_the_origin, rtol=1e-14)


def test_same_inputs_have_the_same_hash_and_others_another():
    hashes = {polygon_beam(ELBOW, SECTION, {"tip": tip}).input_hash for tip in (3.0, 3.0, 2.5)}
    assert len(hashes) == 2


def test_units_are_those_of_the_system():
    assert polygon_beam(ELBOW, SECTION, {}, units="mm-t-s").nominal_units["youngs_modulus"] == "MPa"


@pytest.mark.parametrize(
    ("nodes", "interfaces", "units", "message"),
    [
        (ELBOW[:1], {}, "m-kg-s", r"at least two finite nodes .* shape \(1, 2\)"),
        (ELBOW[:, :1], {}, "m-kg-s", r"shape \(3, 1\)"),
        ([[0.0, 0.0], [np.nan, 0.0]], {}, "m-kg-s", "finite"),
        (ELBOW[[0, 1, 1, 2]], {}, "m-kg-s", "nodes 1 and 2 of the beam coincide"),
        (ELBOW, {"tip": 3.5}, "m-kg-s", "arc length 3.5 is off the skin"),
        (ELBOW, {}, "inch", "unknown unit system 'inch'"),
    ],
)
def test_wrong_inputs_are_refused(nodes, interfaces, units, message):
    with pytest.raises(InputError, match=message):
        polygon_beam(nodes, SECTION, interfaces, units=units)


def test_shapes_of_a_beam_follow_the_place_of_an_interface_point():
    """As those of a skin: stiffness and interface by the arc length, against beams that are built with the point elsewhere."""
    choice = BasisChoice("craig-bampton", count=2)

    def built(tip: float) -> ReducedModel:
        return polygon_beam(ELBOW, SECTION, {"tip": tip}, basis=choice)

    model = built(1.2)
    design, h = DesignPoint(model), 1e-3
    assert "arc_length_tip" in model.nominal
    spread = [
        (np.linalg.eigvalsh(each.invariants.stiffness), each.interfaces["tip"].position[0])
        for each in (built(1.2 + h), built(1.2 - h))
    ]
    (up, place_up), (down, place_down) = spread
    values, vectors = np.linalg.eigh(model.invariants.stiffness)
    rate = scattered(*rates_at(design, "stiffness", {"arc_length_tip": 0}).by(0), values.size**2).reshape(values.size, -1)
    # constraint modes have unit columns at the point and so no freedom; differences of second order in a step of 1e-3
    np.testing.assert_allclose(np.diag(vectors.T @ rate @ vectors), (up - down) / (2 * h), atol=1e-5 * np.abs(up).max())
    moved = scattered(
        *rates_at(design, "interfaces.tip.position", {"arc_length_tip": 0}).by(0), model.interfaces["tip"].position.size
    )
    np.testing.assert_allclose(
        moved.reshape(model.interfaces["tip"].position.shape)[0, :, 0], (place_up - place_down)[:, 0] / (2 * h), atol=1e-9
    )
