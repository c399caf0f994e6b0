"""Which solver factors a solid, how it is told, and that it decides on nothing but the last digits."""

from __future__ import annotations

import sys
from dataclasses import fields
from types import ModuleType

import numpy as np
import pytest
from scipy import sparse

from preprocessing.reduction import solid_systems
from preprocessing.reduction.solid_systems import PardisoFactors, SuperLUFactors, pardiso_factors, superlu_factors
from tests.models.processors import entries
from tests.models.solid_bodies import box, cantilever

EQUAL = 1e-9
"""Relative to the largest entry: the stiffness of this slender body has a condition of 1e6, both solvers leave 1e-16 times that, and
conjugate gradients stop at 1e-11."""


class Refused(Exception):
    """What the stand-in raises for a matrix that is not positive definite."""


class StandIn:
    """What pypardiso's solver promises, with dense matrices; it knows the upper triangle alone, as Pardiso does."""

    freed = 0

    def __init__(self, mtype: int) -> None:
        assert mtype == 2

    def set_iparm(self, number: int, value: int) -> None:
        assert (number, value) in {(1, 1), (2, 2), (8, 0)}

    def factorize(self, upper: sparse.csr_matrix) -> None:
        assert sparse.tril(upper, -1).nnz == 0
        whole = upper.toarray() + np.triu(upper.toarray(), 1).T
        if np.linalg.eigvalsh(whole)[0] <= 0:
            raise Refused
        self.inverse = np.linalg.inv(whole)

    def solve(self, _: sparse.csr_matrix, above: np.ndarray) -> np.ndarray:
        assert above.flags.f_contiguous
        return self.inverse @ above

    def free_memory(self, everything: bool) -> None:
        assert everything
        StandIn.freed += 1


@pytest.fixture
def stand_in(monkeypatch):
    """A package of the name of pypardiso, whether it is installed or not."""
    package, inner = ModuleType("pypardiso"), ModuleType("pypardiso.pardiso_wrapper")
    package.PyPardisoSolver, inner.PyPardisoError = StandIn, Refused
    monkeypatch.setitem(sys.modules, "pypardiso", package)
    monkeypatch.setitem(sys.modules, "pypardiso.pardiso_wrapper", inner)
    monkeypatch.setattr("preprocessing.reduction.solid_systems.version", lambda name: {"pypardiso": "7", "mkl": "8"}[name])


@pytest.fixture
def without_pardiso(monkeypatch):
    monkeypatch.setitem(sys.modules, "pypardiso", None)


@pytest.fixture
def body(tmp_path):
    return lambda: cantilever(tmp_path, box("hexahedron", (10, 3, 2), (1.0, 0.2, 0.15)), 'kind = "craig-bampton"\ncount = 8')


def stiffness(n: int) -> sparse.csr_array:
    return sparse.diags_array([np.full(n, 2.0), np.full(n - 1, -1.0), np.full(n - 1, -1.0)], offsets=[0, -1, 1]).tocsr()


def close(one, other) -> None:
    """Two reduced models of the same body by two solvers."""
    assert dict(entries(one)).keys() == dict(entries(other)).keys()
    for field in fields(one.invariants):
        a, b = (getattr(model.invariants, field.name) for model in (one, other))
        np.testing.assert_allclose(a, b, rtol=0, atol=EQUAL * np.abs(b).max(initial=0))
    for item, a in one.derivatives.items():
        b = other.derivatives[item]
        np.testing.assert_array_equal(a.entry, b.entry)
        np.testing.assert_allclose(a.value, b.value, rtol=0, atol=EQUAL * np.abs(b.value).max())


def test_a_small_body_is_factored_by_superlu_whatever_is_installed(stand_in, body):
    assert [name for name in body().writers if "LU" in name or "Pardiso" in name] == ["SuperLU"]


def test_a_large_body_is_factored_by_pardiso_where_it_is_installed_and_the_model_tells(stand_in, body, monkeypatch):
    small = body()
    monkeypatch.setattr(solid_systems, "PARDISO_FROM", 100)
    large = body()
    assert large.writers["MKL Pardiso"] == "pypardiso 7, mkl 8"
    assert "SuperLU" not in large.writers
    close(large, small)


def test_a_large_body_is_factored_by_superlu_where_pardiso_is_missing_and_the_model_tells(without_pardiso, body, monkeypatch):
    monkeypatch.setattr(solid_systems, "PARDISO_FROM", 100)
    assert body().writers["SuperLU"].startswith("scipy ")
    assert pardiso_factors(stiffness(5)) is None
    assert isinstance(solid_systems.factored(stiffness(200), None), SuperLUFactors)


def test_what_pardiso_refuses_goes_to_superlu(stand_in):
    """Pardiso stops at a pivot that is not positive; SuperLU tells a matrix that is singular apart from one that is nearly so."""
    assert pardiso_factors(stiffness(5) - 3 * sparse.eye_array(5)) is None


def test_memory_of_pardiso_is_given_back(stand_in):
    found, before = pardiso_factors(stiffness(5)), StandIn.freed
    assert isinstance(found, PardisoFactors)
    del found
    assert StandIn.freed == before + 1


def test_pardiso_itself_and_superlu_agree(body, monkeypatch):
    """With what is installed; the tests above hold without."""
    pytest.importorskip("pypardiso", reason="the extra `solids` is not installed")
    small = body()
    monkeypatch.setattr(solid_systems, "PARDISO_FROM", 100)
    large = body()
    assert "MKL Pardiso" in large.writers
    close(large, small)


def test_every_solve_that_is_not_kept_costs_one_column_and_none_when_it_has_converged(body, monkeypatch):
    """Lanczos, static shapes and derivatives of 8 modes by one parameter take 161. With a refinement of every solve, and all columns
    solved for until the last one has converged, it was 302; columns are counted, not seconds."""
    columns, solve = [], SuperLUFactors.solve

    def counted(self, above):
        columns.append(above.shape[1])
        return solve(self, above)

    monkeypatch.setattr(SuperLUFactors, "solve", counted)
    body()
    assert sum(columns) < 200


@pytest.mark.parametrize("dimension", [2, 3])
def test_superlu_solves_in_the_order_of_the_coordinates(dimension):
    rng = np.random.default_rng(4)
    matrix, places = stiffness(300), rng.normal(size=(300, dimension))
    load = rng.normal(size=(300, 2))
    np.testing.assert_allclose(matrix @ superlu_factors(matrix, places).solve(load), load, atol=1e-11)  # condition 1e5
