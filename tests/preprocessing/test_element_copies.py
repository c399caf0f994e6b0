"""Elements that stand twice, numbers that occur, and parts that hang together: the fast ways beside the plain ones."""

from __future__ import annotations

import numpy as np
import pytest

from preprocessing.mesh import element_numbering
from preprocessing.mesh.element_numbering import distinct, first_of_copies
from preprocessing.mesh.solid_mesh import lumps

RNG = np.random.default_rng(4)


def plain(elements: np.ndarray) -> np.ndarray:
    """By sorting the rows of their nodes in order."""
    found = np.zeros(len(elements), bool)
    found[np.unique(np.sort(elements, axis=1), axis=0, return_index=True)[1]] = True
    return found


@pytest.mark.parametrize("n_nodes", [6, 12, 1000])
@pytest.mark.parametrize("n_local", [3, 4, 8])
def test_first_of_copies_are_those_of_sorted_rows_in_any_order_of_their_nodes(n_nodes, n_local):
    elements = RNG.integers(n_nodes, size=(300, n_local))
    copied = RNG.permuted(elements[RNG.integers(300, size=100)], axis=1)
    every = np.concatenate([elements, copied])[RNG.permutation(400)]
    np.testing.assert_array_equal(first_of_copies(every), plain(every))
    assert first_of_copies(every).sum() < 400


def test_different_elements_of_one_sum_are_told_apart(monkeypatch):
    """Plain sums of the numbers instead of scrambled ones: 0 + 3 is 1 + 2."""
    elements = RNG.integers(9, size=(200, 4))
    monkeypatch.setattr(element_numbering, "_scrambled", lambda numbers: numbers)
    np.testing.assert_array_equal(first_of_copies(elements), plain(elements))


def test_no_copies_and_no_elements_are_all_first():
    assert first_of_copies(np.arange(12).reshape(3, 4)).tolist() == [True, True, True]
    assert first_of_copies(np.zeros((0, 4), int)).tolist() == []


@pytest.mark.parametrize("count", [0, 3, 500])
def test_distinct_numbers_are_those_of_a_sort(count):
    numbers = RNG.integers(1000, size=(count, 2))
    np.testing.assert_array_equal(distinct([numbers], 1000), np.unique(numbers))


def test_lumps_are_counted_by_their_first_node():
    """Triangles 4-1-0 and 1-2-2, a line 5-3, and the node 6 alone."""
    members = [np.array([[4, 1, 0], [1, 2, 2]]), np.array([[5, 3]])]
    assert lumps(7, members).tolist() == [0, 0, 0, 1, 0, 1, 2]
