"""Constraint modes against Hermite's cubics, the minimum of the strain energy, and complex steps."""

import numpy as np
import pytest

from preprocessing.reduction.constrained_pencil import ConstrainedPencil, constraint_modes
from tests.models.frames import cantilever, relative, varied, wing
from toolkit.foundation.errors import InputError


def boundary(frame) -> np.ndarray:
    """Clamped first node and all points of the frame."""
    n = 3 * len(frame.nodes)
    return np.vstack([np.eye(n)[:3], *frame.interface_rows().values()])


@pytest.fixture
def frame():
    """The wing's skin with a point on a node and one inside an element."""
    return type(wing())(wing().nodes, wing().connectivity, points={"inside": 24.37, "node": 10.0})


def test_tip_motions_of_a_cantilever_are_hermite_cubics():
    """Between its ends the beam is free of load, so that its axis is linear and its deflection cubic, at any mesh."""
    length, n = 100.0, 7
    shapes = constraint_modes(cantilever(n).matrices()[0], boundary(cantilever(n, points={"tip": float(n)}))).shapes[:, 3:]
    r = np.linspace(0, 1, n + 1)
    u, v, turn = shapes[0::3], shapes[1::3], shapes[2::3]
    zero = np.zeros_like(r)
    # condition number 1e5 times round-off
    np.testing.assert_allclose(u, np.column_stack([r, zero, zero]), atol=1e-10)
    np.testing.assert_allclose(v, np.column_stack([zero, 3 * r**2 - 2 * r**3, length * (r**3 - r**2)]), atol=1e-10 * length)
    np.testing.assert_allclose(turn, np.column_stack([zero, (6 * r - 6 * r**2) / length, 3 * r**2 - 2 * r]), atol=1e-10)


def test_shapes_meet_the_boundary_and_store_the_least_energy(frame):
    """Least energy: the forces K Psi do no work on any motion that the boundary allows."""
    stiffness, rows = frame.matrices()[0], boundary(frame)
    modes = constraint_modes(stiffness, rows)
    np.testing.assert_allclose(rows @ modes.shapes, np.eye(len(rows)), atol=1e-11)  # round-off of numbers up to 1e2
    forces = stiffness @ modes.shapes + rows.T @ modes.reactions
    assert np.abs(forces).max() < 1e-12 * (np.abs(stiffness) @ np.abs(modes.shapes)).max()  # round-off


@pytest.mark.parametrize("variable", ["thickness", "element", "shape", "place"])
def test_derivative_is_the_complex_step_of_the_whole_computation(frame, variable):
    changed = varied(frame, variable, 1e-30j)
    exact = constraint_modes(changed.matrices()[0], boundary(changed)).shapes.imag / 1e-30
    zero = np.zeros((93, 93))
    d = ConstrainedPencil(changed.matrices()[0].imag / 1e-30, zero, boundary(changed).imag / 1e-30)
    ours = constraint_modes(frame.matrices()[0], boundary(frame)).rates([d])[:, :, 0]
    assert relative(ours, exact) < 1e-9  # round-off times the condition of the skin's stiffness, 1e7


def test_a_boundary_that_does_not_hold_the_body_is_refused(frame):
    n = 3 * len(frame.nodes)
    with pytest.raises(InputError, match="holds the body and whose 2 rows are independent"):
        constraint_modes(frame.matrices()[0], np.eye(n)[:2])


def test_repeated_rows_are_refused(frame):
    rows = boundary(frame)
    with pytest.raises(InputError, match="name every interface point once"):
        constraint_modes(frame.matrices()[0], np.vstack([rows, rows[-1:]]))
