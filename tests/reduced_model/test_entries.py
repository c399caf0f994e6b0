"""Items of a reduced model at one design: the same bits however they are asked for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from toolkit.reduced_model.dependence import ENTRIES_AT_ONCE
from toolkit.reduced_model.design_point import DesignPoint, elastic_matrices
from toolkit.reduced_model.file import load
from toolkit.reduced_model.model import ReducedModel

SKIN = Path(__file__).parents[2] / "models" / "morphing_wing" / "skin.h5"
ITEMS = ("stiffness", "damping", "inertia", "first_moment", "gyroscopic", "stress_operator", "shape.position")
DESIGNS = {
    "nominal": {},
    "other numbers": {"thickness": 1.6, "youngs_modulus": 6.9e4},
    "a step off the nominal design": {"thickness": 1.5 + 1e-30j},
    "a step off others": {"thickness": 1.6, "youngs_modulus": 6.9e4 + 1e-30j, "damping_stiffness": 1e-5},
}


@pytest.fixture(scope="module")
def model() -> ReducedModel:
    return load(SKIN)


@pytest.mark.parametrize("values", DESIGNS.values(), ids=DESIGNS)
def test_items_do_not_depend_on_what_else_was_asked_for(model, values):
    alone = {
        item: DesignPoint(replace(model), values).value(item) for item in ITEMS
    }  # of a model that has been asked for nothing
    one = replace(model)
    for _ in range(2):  # the second time all are found at once
        design = DesignPoint(one, values)
        for item in ITEMS:
            found = design.value(item)
            assert found.dtype == alone[item].dtype
            assert np.array_equal(found, alone[item]), item


def test_polynomials_that_are_large_together_are_evaluated_apart(model):
    one = replace(model)
    designs = [DesignPoint(one, {"thickness": 1.5 + 0.1 * k}) for k in (1, 2)]
    for design in designs:
        for item in ITEMS:
            design.value(item)
    together = one.told[designs[0].kind, False]
    assert 0 < len(together.polynomial.entry) <= ENTRIES_AT_ONCE
    assert sum(len(one.affine[item].entry) for item in together.places) == len(together.polynomial.entry)


@pytest.mark.parametrize("values", DESIGNS.values(), ids=DESIGNS)
def test_elastic_matrices_are_the_entries_that_are_not_zero(model, values):
    design = DesignPoint(replace(model), values)
    inertia, damping, stiffness = design.some_invariants("inertia", "damping", "stiffness")
    row, column = np.nonzero((inertia[1:, 1:] != 0) | (damping != 0) | (stiffness != 0))
    for _ in range(2):  # looked up, and known
        found = elastic_matrices(design, "inertia", "damping", "stiffness")
        assert np.array_equal(found.row, row)
        assert np.array_equal(found.column, column)
        for values_there, matrix in zip(found.values, (inertia[1:, 1:], damping, stiffness), strict=True):
            assert values_there.dtype == matrix.dtype
            assert np.array_equal(values_there, matrix[row, column])
