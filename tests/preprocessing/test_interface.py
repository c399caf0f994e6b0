"""Interface points: Hermite interpolation inside elements, the nodes' coordinates at nodes, exact derivatives by arc length."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from preprocessing.elements.beams import PlanarBeam
from preprocessing.reduction.assembly import interface_point
from preprocessing.reduction.chosen_basis import tangent_frame
from toolkit.foundation.errors import InputError

ANGLE = np.linspace(0.4, 3.6, 6)
NODES = np.column_stack([80 * np.cos(ANGLE), 30 * np.sin(ANGLE)])
ARC_LENGTHS = np.concatenate([[0.0], np.cumsum(1.01 * np.linalg.norm(np.diff(NODES, axis=0), axis=1))])
"""Arc lengths of a curve that is 1 % longer than its polygon."""
BEAMS = PlanarBeam(NODES, np.column_stack([np.arange(5), np.arange(1, 6)]), [])
Z = tangent_frame(NODES, 0, "F").z
INSIDE = ARC_LENGTHS[2] + 0.3 * (ARC_LENGTHS[3] - ARC_LENGTHS[2])


def state() -> np.ndarray:
    return np.concatenate([[1.0], np.random.default_rng(2).normal(size=Z.shape[1] - 1)])


def test_position_and_rotation_inside_an_element_are_its_hermite_interpolation():
    """Reference: linear interpolation along the element, a cubic Hermite spline across it."""
    q = state()
    one, two = (Z @ q).reshape(-1, 3)[2:4]
    length = np.linalg.norm(NODES[3] - NODES[2])
    e = (NODES[3] - NODES[2]) / length
    n = np.array([-e[1], e[0]])
    across = CubicHermiteSpline([0, length], [n @ one[:2], n @ two[:2]], [one[2], two[2]])
    x = 0.3 * length
    expected = e * (0.7 * (e @ one[:2]) + 0.3 * (e @ two[:2])) + n * across(x)
    position, rotation = interface_point(BEAMS, ARC_LENGTHS, Z, INSIDE).at(INSIDE)
    np.testing.assert_allclose(position @ q, expected, rtol=1e-12)  # round-off
    np.testing.assert_allclose(rotation @ q, across(x, 1), rtol=1e-12)


def test_polynomials_about_different_centres_are_the_same_function():
    other = INSIDE + 3.0
    for one, two in zip(
        interface_point(BEAMS, ARC_LENGTHS, Z, INSIDE).at(other),
        interface_point(BEAMS, ARC_LENGTHS, Z, other).at(other),
        strict=True,
    ):
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-12 * np.abs(two).max())  # round-off


def test_derivative_by_arc_length_is_exact():
    """The first coefficient, the complex step and the slope of the straight element agree."""
    point = interface_point(BEAMS, ARC_LENGTHS, Z, INSIDE)
    position, rotation = point.at(INSIDE + 1e-30j)
    np.testing.assert_allclose(position.imag / 1e-30, point.position[1], rtol=1e-13, atol=1e-15)  # round-off
    np.testing.assert_allclose(rotation.imag / 1e-30, point.rotation[1], rtol=1e-13, atol=1e-15)
    chord = (NODES[3] - NODES[2]) / (ARC_LENGTHS[3] - ARC_LENGTHS[2])
    np.testing.assert_allclose(point.position[1][:, 0], chord, rtol=1e-12)


@pytest.mark.parametrize("node", range(1, 5))
def test_position_and_rotation_are_continuous_at_nodes(node):
    at_node = interface_point(BEAMS, ARC_LENGTHS, Z, ARC_LENGTHS[node]).at(ARC_LENGTHS[node])
    for element in (node - 1, node):
        middle = ARC_LENGTHS[element : element + 2].mean()
        beside = interface_point(BEAMS, ARC_LENGTHS, Z, middle).at(ARC_LENGTHS[node])
        np.testing.assert_allclose(beside[0], at_node[0], rtol=0, atol=1e-12 * 80)  # round-off of the coordinates
        np.testing.assert_allclose(beside[1], at_node[1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("node", [0, 3, 5])
def test_point_on_a_node_has_one_power_and_no_range(node):
    point = interface_point(BEAMS, ARC_LENGTHS, Z, ARC_LENGTHS[node] * (1 + 1e-14))
    assert point.arc_length_range.tolist() == [ARC_LENGTHS[node]] * 2
    assert len(point.position) == len(point.rotation) == 1
    assert np.array_equal(point.position[0], Z[3 * node : 3 * node + 2])
    assert np.array_equal(point.rotation[0], Z[3 * node + 2])


@pytest.mark.parametrize("arc_length", [-1.0, 1e4])
def test_point_off_the_skin_is_refused(arc_length):
    with pytest.raises(InputError, match="is off the skin, which reaches from 0 to"):
        interface_point(BEAMS, ARC_LENGTHS, Z, arc_length)
