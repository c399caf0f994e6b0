"""Interface points: position and rotation of a place on the skin as polynomials of its arc length.

Mesh, arc lengths and basis may carry a complex step in a parameter of the shape; real parts decide where the point lies.
"""

from __future__ import annotations

from math import comb

import numpy as np

from preprocessing.elements.block_element import LineElement
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import InterfacePoint

ON_NODE = 1e-9
"""A point closer to a node than this part of the skin's length is on the node."""

MOVES_ALONG = 1e-6
"""Parts of the largest movement that a point may lag behind its node; round-off is far below."""


def interface_point(beams: LineElement, arc_lengths: np.ndarray, z: np.ndarray, arc_length: complex) -> InterfacePoint:
    """Interface point at one arc length.

    Inside an element the arc length s on the true curve is mapped linearly to the place r = (s - s_1) / (s_2 - s_1) on the
    straight element, where `position` and `rotation` are cubic and quadratic. At a node they are the node's coordinates.

    Parameters
    ----------
    arc_lengths : (n_nodes,)
        Arc length of every node from F along the true curve.
    z : (n, 1 + n_f)
        The basis [xi, Psi]; in space a rotation has three rows.

    Raises
    ------
    InputError
        The arc length is not on the skin; or it is that of a node, but does not move with it under a complex step: the polygon of
        elements has a kink there, and the point no derivative.
    """
    nodes, place = np.real(arc_lengths), np.real(arc_length)
    nearest = int(np.abs(nodes - place).argmin())
    if abs(nodes[nearest] - place) <= ON_NODE * (nodes[-1] - nodes[0]):
        _refuse_passing(arc_lengths, nearest, arc_length)
        return node_point(beams, z, nearest, arc_lengths[nearest])
    if not nodes[0] <= place <= nodes[-1]:
        raise InputError(f"arc length {place:g} is off the skin, which reaches from {nodes[0]:g} to {nodes[-1]:g}.")
    element = int(np.searchsorted(nodes, place)) - 1
    return _inside_element(beams, z, element, arc_lengths[element : element + 2], arc_length)


def _refuse_passing(arc_lengths: np.ndarray, node: int, arc_length: complex) -> None:
    """Refuse a place that is at the node now, but moves otherwise than the node does."""
    if abs(np.imag(arc_lengths[node] - arc_length)) > MOVES_ALONG * np.abs(np.imag([*arc_lengths, arc_length])).max():
        raise InputError(
            f"arc length {np.real(arc_length):g} is that of node {node}, but a parameter of the shape moves the node and not the "
            f"point: at the kink between two elements it has no derivative. Write node = {node} if it belongs to the node, or "
            "choose a place off the nodes."
        )


def node_point(beams: LineElement, z: np.ndarray, node: int, arc_length: complex = 0.0) -> InterfacePoint:
    """Interface point at a node; it cannot move along the elements, and of a frame its arc length is 0."""
    dimension = beams.nodes.shape[1]
    rows = z[beams.per_node * node : beams.per_node * (node + 1)]
    turned = rows[2] if dimension == 2 else rows[3:]
    return InterfacePoint(np.asarray(arc_length), np.array([arc_length, arc_length]), rows[None, :dimension], turned[None])


def _inside_element(beams: LineElement, z: np.ndarray, element: int, interval: np.ndarray, arc_length: complex) -> InterfacePoint:
    dofs, displacement, rotation = beams.functions(element)
    step = interval[1] - interval[0]
    ratio = (arc_length - interval[0]) / step
    local = z[dofs]
    return InterfacePoint(
        np.asarray(arc_length),
        np.array(interval),
        _about(displacement, ratio, step) @ local,
        _about(rotation, ratio, step) @ local,
    )


def _about(coefficients: np.ndarray, ratio: complex, step: complex) -> np.ndarray:
    """Coefficients of (s - s_0)^k of a polynomial given by its coefficients of r^j, r = ratio + (s - s_0) / step."""
    powers = range(len(coefficients))
    shift = np.array([[comb(j, k) * ratio ** (j - k) / step**k if j >= k else 0.0 for j in powers] for k in powers])
    return np.tensordot(shift, coefficients, axes=1)
