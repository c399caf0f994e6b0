"""Interface points: position and rotation of a place on the skin as polynomials of its arc length."""

from __future__ import annotations

from math import comb

import numpy as np

from preprocessing import beam
from preprocessing.mesh import CurveMesh
from toolkit.errors import InputError
from toolkit.reduced_model import InterfacePoint

ON_NODE = 1e-9
"""A point closer to a node than this part of the skin's length is on the node."""


def interface_point(mesh: CurveMesh, arc_lengths: np.ndarray, z: np.ndarray, arc_length: float) -> InterfacePoint:
    """The interface point at one arc length.

    Inside an element the arc length s on the true curve is mapped linearly to the place r = (s - s_1) / (s_2 - s_1) on the
    straight element, where `position` and `rotation` are cubic and quadratic. At a node they are the node's coordinates.

    Parameters
    ----------
    arc_lengths : (n_nodes,)
        Arc length of every node from F along the true curve.
    z : (n, 1 + n_f)
        The basis [xi, Psi].

    Raises
    ------
    InputError
        The arc length is not on the skin.
    """
    start, end = arc_lengths[0], arc_lengths[-1]
    nearest = int(np.abs(arc_lengths - arc_length).argmin())
    if abs(arc_lengths[nearest] - arc_length) <= ON_NODE * (end - start):
        return _at_node(z, nearest, arc_lengths[nearest])
    if not start <= arc_length <= end:
        raise InputError(f"arc length {arc_length:g} is off the skin, which reaches from {start:g} to {end:g}.")
    element = int(np.searchsorted(arc_lengths, arc_length)) - 1
    return _inside_element(mesh, z, element, arc_lengths[element : element + 2], arc_length)


def _at_node(z: np.ndarray, node: int, arc_length: float) -> InterfacePoint:
    rows = z[3 * node : 3 * node + 3]
    return InterfacePoint(np.asarray(arc_length), np.array([arc_length, arc_length]), rows[None, :2], rows[None, 2])


def _inside_element(mesh: CurveMesh, z: np.ndarray, element: int, interval: np.ndarray, arc_length: float) -> InterfacePoint:
    ends = mesh.ends[element : element + 1]
    step = interval[1] - interval[0]
    ratio = (arc_length - interval[0]) / step
    local = z[mesh.dofs[element]]
    return InterfacePoint(
        np.asarray(arc_length),
        np.array(interval),
        _about(beam.shape(ends)[0], ratio, step) @ local,
        _about(beam.rotation(ends)[0], ratio, step) @ local,
    )


def _about(coefficients: np.ndarray, ratio: float, step: float) -> np.ndarray:
    """Coefficients of (s - s_0)^k of a polynomial given by its coefficients of r^j, r = ratio + (s - s_0) / step."""
    powers = range(len(coefficients))
    shift = np.array([[comb(j, k) * ratio ** (j - k) / step**k if j >= k else 0.0 for j in powers] for k in powers])
    return np.tensordot(shift, coefficients, axes=1)
