"""The factors of a chain's stiffness: they make it, at every design, and know rigid motions."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.models.scenes import MODELS
from toolkit.components.bodies.chain_strains import PER_NODE, Strains, chain_strains
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load
from toolkit.system.body_arrays import factored_bodies

STEP = 1e-30
ROUND_OFF = 1e-14
"""Relative to the diagonal: some roundings of the entries."""


def strains_of(stiffness: np.ndarray) -> Strains:
    """By the entries of a matrix."""
    row, column = np.nonzero(stiffness)
    return chain_strains(row, column, stiffness[row, column], len(stiffness))


def rows_of(strains: Strains, size: int) -> np.ndarray:
    """B as a matrix."""
    found = np.zeros((len(strains.weight), size), strains.value.dtype)
    np.add.at(found, (np.arange(len(found))[:, None], strains.column), strains.value)
    return found


@pytest.fixture(scope="module")
def skin():
    return load(MODELS / "skin.h5")


def cantilever(places: np.ndarray, bend: float = 3.0, stretch: float = 700.0) -> np.ndarray:
    """Stiffness of straight elements between places (n + 1, 2), all coordinates of the nodes; from the beam's slopes and deflections."""
    size = PER_NODE * len(places)
    found = np.zeros((size, size))
    for k, (dx, dy) in enumerate(np.diff(places, axis=0)):
        length = np.hypot(dx, dy)
        turn = np.eye(6)
        turn[:2, :2] = turn[3:5, 3:5] = np.array([[dx, dy], [-dy, dx]]) / length
        w, r = 12 * bend / length**3, 6 * bend / length**2
        local = np.zeros((6, 6))
        local[np.ix_([0, 3], [0, 3])] = stretch / length * np.array([[1, -1], [-1, 1]])
        local[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = np.array(
            [
                [w, r, -w, r],
                [r, 4 * bend / length, -r, 2 * bend / length],
                [-w, -r, w, -r],
                [r, 2 * bend / length, -r, 4 * bend / length],
            ]
        )
        own = slice(PER_NODE * k, PER_NODE * (k + 2))
        found[own, own] += turn.T @ local @ turn
    return found


@pytest.mark.parametrize("variable", ["thickness", "youngs_modulus", "width"])
def test_factors_make_the_stiffness_of_the_wing_and_its_derivative(skin, variable):
    stiffness = DesignPoint(skin, {variable: skin.nominal[variable] * (1 + 1j * STEP)}).value("stiffness")
    strains = strains_of(stiffness)
    rows = rows_of(strains, len(stiffness))
    made, scale = rows.T @ (strains.weight[:, None] * rows), np.sqrt(np.diag(stiffness.real))
    assert len(strains.weight) == PER_NODE * 30
    np.testing.assert_allclose((made - stiffness).real / np.outer(scale, scale), 0, atol=ROUND_OFF)
    np.testing.assert_allclose((made - stiffness).imag / STEP / np.outer(scale, scale), 0, atol=3 * ROUND_OFF)  # thickness^3


@pytest.mark.parametrize("held", ["first", "last"])
def test_elements_of_a_bent_chain_are_found_from_either_end(held):
    """Their weights are EA/l, EI/l and 3 EI/l of each, and rigid motions of what is not held strain one element alone."""
    places = np.array([[0.0, 0.0], [1.0, 0.2], [1.5, 1.2], [1.2, 3.0], [-0.5, 3.1]])
    free = slice(PER_NODE, None) if held == "first" else slice(0, -PER_NODE)
    strains = strains_of(cantilever(places)[free, free])
    length = np.hypot(*np.diff(places, axis=0).T)
    expected = np.roll(length, -1) if held == "first" else length  # the element that is held comes last
    np.testing.assert_allclose(strains.weight, np.outer(1 / expected, [700.0, 3.0, 9.0]).ravel(), rtol=1e-12)
    x, y = places[1:].T if held == "first" else places[:-1].T
    turned = np.column_stack([-y, x, np.ones(len(x))]).ravel()
    strained = np.abs(rows_of(strains, len(turned)) @ turned) > 1e-13
    assert not np.any(strained[:-PER_NODE])
    assert np.any(strained[-PER_NODE:])


def other_bodies() -> dict[str, np.ndarray]:
    places = np.column_stack([np.arange(5.0), np.zeros(5)])
    chain = cantilever(places)[PER_NODE:, PER_NODE:]
    spring, shear = chain.copy(), chain.copy()
    spring[4, 4] += 1e-3 * spring[4, 4]
    shear[3:6, 6:9] *= 1.01
    shear[6:9, 3:6] *= 1.01
    rng = np.random.default_rng(1).normal(size=(12, 12))
    return {
        "a chain that nothing holds": cantilever(places),
        "one that a spring holds in its middle": spring,
        "elements of another kind": shear,
        "shapes that all feel each other": rng @ rng.T,
        "one shape": np.eye(1),
    }


@pytest.mark.parametrize("what", other_bodies())
def test_other_bodies_have_no_factors(what):
    assert len(strains_of(other_bodies()[what]).weight) == 0


def test_springs_as_soft_as_the_round_off_of_long_chains_are_no_part_of_the_factors():
    """One of 1e-13 of an element's stiffness is 2e-4 of that of a cantilever of a thousand."""
    chain = cantilever(np.column_stack([np.arange(6.0), np.zeros(6)]))[PER_NODE:, PER_NODE:]
    assert len(strains_of(chain).weight) > 0
    chain[-2, -2] += 1e-13 * chain[4, 4]
    assert len(strains_of(chain).weight) == 0


def test_a_body_whose_derivative_is_no_chain_keeps_its_entries():
    """A spring at the tip that is zero at this design."""
    chain = cantilever(np.column_stack([np.arange(6.0), np.zeros(6)]))[PER_NODE:, PER_NODE:].astype(complex)
    chain[-2, -2] += 1j * STEP
    rate = strains_of(chain)
    assert len(rate.weight) == 0
    known = strains_of(chain.real)

    def of(*bodies: Strains) -> Any:
        return SimpleNamespace(constant={b: SimpleNamespace(strains=strains) for b, strains in enumerate(bodies)})

    assert factored_bodies(of(known, known), [of(known, known)]) == {0, 1}
    assert factored_bodies(of(known, known), [of(known, rate)]) == {0}
