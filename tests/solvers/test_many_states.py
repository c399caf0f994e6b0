"""Stability of many states at once: against eigenvalues of the stiffness among the motions that the joints allow."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import scipy

from toolkit.solvers.static.critical_state import StaticEntries, are_positive

COORDINATES, TIES, STATES = 12, 3, 6
SIZES = np.geomspace(0.1, 30.0, COORDINATES)
SYSTEM = SimpleNamespace(
    n=COORDINATES + TIES, n_b=COORDINATES, weights=np.append(SIZES, np.ones(TIES)), plan=SimpleNamespace(dropped=np.zeros(0, int))
)


def matrices(least: float, everywhere: bool, seed: int = 1) -> np.ndarray:
    """Static matrices (k, n, n) whose last one has a least stiffness among the motions that are allowed; joints hold the first four
    coordinates, and the stiffness differs there and against the seventh, or everywhere."""
    random = np.random.default_rng(seed)
    found = np.zeros((STATES, SYSTEM.n, SYSTEM.n))
    root = random.normal(size=(COORDINATES, COORDINATES))
    stiffness = root @ root.T / COORDINATES + np.eye(COORDINATES)
    for k in range(STATES):
        change = random.normal(size=(COORDINATES, COORDINATES))
        if not everywhere:
            change[:, [4, 5, *range(7, COORDINATES)]] = 0.0
            change[4:6, :4] = change[7:, :4] = 0.0
        ties = np.zeros((COORDINATES, TIES))
        ties[:4] = random.normal(size=(4, TIES))
        found[k, :COORDINATES, :COORDINATES] = stiffness + 0.02 * (change + change.T)
        found[k, :COORDINATES, COORDINATES:], found[k, COORDINATES:, :COORDINATES] = ties, ties.T
    allowed = scipy.linalg.null_space(found[-1, COORDINATES:, :COORDINATES])
    values, shapes = scipy.linalg.eigh(allowed.T @ found[-1, :COORDINATES, :COORDINATES] @ allowed)
    softest = allowed @ shapes[:, 0]
    place = 6 if not everywhere else int(np.argmax(np.abs(softest)))
    lowered = np.zeros((COORDINATES, COORDINATES))
    lowered[place, place] = 1.0
    size = scipy.optimize.brentq(
        lambda much: (
            np.linalg.eigvalsh(allowed.T @ (found[-1, :COORDINATES, :COORDINATES] - much * lowered) @ allowed)[0] - least
        ),
        -1e3 if values[0] < least else 0.0,
        1e3,
    )
    found[-1, :COORDINATES, :COORDINATES] -= size * lowered
    scale = np.append(SIZES, np.ones(TIES))
    return found * scale * scale[:, None]  # in coordinates that are not of comparable size


def entries(found: np.ndarray) -> StaticEntries:
    """All of them but for those that are zero in every state."""
    rows, columns = np.nonzero(np.any(found != 0, axis=0))
    return StaticEntries(rows, columns, found[:, rows, columns])


@pytest.mark.parametrize("everywhere", [False, True])
def test_states_are_positive_if_and_only_if_all_stiffnesses_among_allowed_motions_are(everywhere):
    assert are_positive(SYSTEM, entries(matrices(1e-2, everywhere)))
    assert not are_positive(SYSTEM, entries(matrices(-1e-2, everywhere)))


def test_a_stiffness_that_is_not_symmetric_is_not_known_to_be_positive():
    found = matrices(1e-2, everywhere=False)
    found[2, 0, 6] *= 1 + 1e-9
    assert not are_positive(SYSTEM, entries(found))


def test_entries_are_added_at_known_places_and_at_new_ones():
    static = entries(matrices(1e-2, everywhere=False))
    rows, columns = np.array([3, 14]), np.array([3, 14])  # the second is none of the pattern
    more = np.arange(2.0 * STATES).reshape(STATES, 2)
    everything = np.arange(SYSTEM.n)
    expected = static.block(everything, everything)
    expected[:, rows, columns] += more
    np.testing.assert_array_equal(static.added(rows, columns, more).block(everything, everything), expected)
