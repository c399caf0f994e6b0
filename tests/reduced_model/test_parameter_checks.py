"""Numbers of a section that no body has are refused, where formulas of the reduced model would go on with them."""

from __future__ import annotations

import re

import pytest

from toolkit.foundation.errors import InputError
from toolkit.reduced_model.questions import check_parameters

NOMINAL = {
    "diameter_leg": 0.02, "wall_leg": 0.004, "thickness_arm": 0.01, "width_arm": 0.03, "thickness_bar": 0.01, "width_bar": 0.01,
    "poisson_ratio_steel": 0.3, "damping_mass": 0.0, "thickness_nose": 0.001, "thickness": 0.001, "width": 0.02, "bump": 0.0,
}  # fmt: skip
WRONG = [
    ({"diameter_leg": -0.02, "wall_leg": -0.004}, "bodies.b.diameter_leg = -0.02 must be a positive number"),  # even powers alone
    ({"wall_leg": 0.012}, "a wall_leg of 0.012 is more than half the diameter_leg of 0.02"),
    ({"diameter_leg": 0.007}, "a wall_leg of 0.004 is more than half the diameter_leg of 0.007"),
    ({"poisson_ratio_steel": 0.5}, "bodies.b.poisson_ratio_steel = 0.5 must be above -1 and below 0.5"),
    ({"thickness_arm": 0.037}, "with thickness_arm = 0.037 and width_arm = 0.03 the side is the longer one"),
    ({"thickness_bar": 0.0121}, "with thickness_bar = 0.0121 and width_bar = 0.01 the side"),
    ({"width": 0.0005}, "with thickness = 0.001 and width = 0.0005 the side"),
]
RIGHT = [
    {"diameter_leg": 0.008}, {"wall_leg": 0.01}, {"thickness_arm": 0.036}, {"thickness_bar": 0.005}, {"bump": -1.0}, {"damping_mass": 0.0},
    {"thickness_nose": 0.02}, {"diameter_leg": 0.02 + 1e-30j},
]  # fmt: skip


@pytest.mark.parametrize(("values", "words"), WRONG, ids=lambda each: str(each)[:40])
def test_numbers_that_no_section_has_are_refused(values, words):
    with pytest.raises(InputError, match=re.escape(words)):
        check_parameters(values, NOMINAL, "bodies.b", 3)


@pytest.mark.parametrize("values", RIGHT, ids=lambda each: str(each)[:40])
def test_numbers_that_a_section_can_have_pass(values):
    check_parameters(values, NOMINAL, "bodies.b", 3)


def test_a_rectangle_in_the_plane_has_no_torsion_to_be_wrong():
    check_parameters({"thickness_arm": 0.05}, NOMINAL, "bodies.b", 2)
