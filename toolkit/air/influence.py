r"""Stream function of straight panels of vortices and of sources, at the nodes of a contour, and its derivatives by all nodes.

A panel leads from $z_1$ to $z_2$, with $d = z_2 - z_1$, length $L$, tangent $t = d / L$ and normal $n$, to the left. A node $z$ lies at
$X = t \cdot (z - z_1)$ along and $Y = n \cdot (z - z_1)$ beside it. With $r_1^2 = X^2 + Y^2$ and $r_2^2 = (X - L)^2 + Y^2$ these integrals
over the panel give all that the stream function needs (Drela 1989, XFOIL):

$$S = \int \ln r \,\text{d}s, \qquad M = \int (X - s) \ln r \,\text{d}s, \qquad B = -\int \operatorname{atan2}(X - s, Y) \,\text{d}s$$

A vortex sheet whose strength is linear along the panel has the weights $P_2 = (X S - M) / L$ at its end and $P_1 = S - P_2$ at its start.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

Rate = np.ndarray | float


SAME = 1e-9
"""Distance in lengths of a panel below which a node lies at its end: both nodes of a sharp tail do."""


class Panels(NamedTuple):
    """Straight panels, and where nodes lie beside them."""

    tangents: np.ndarray
    """Unit vectors along the panels, shape (panels, 2)."""
    normals: np.ndarray
    """Unit vectors to their left, shape (panels, 2)."""
    lengths: np.ndarray
    """Shape (panels,)."""
    along: np.ndarray
    """X of every node, shape (nodes, panels)."""
    beside: np.ndarray
    """Y of every node, shape (nodes, panels)."""
    starts: np.ndarray
    """Whether the node lies where the panel starts, shape (nodes, panels)."""
    ends: np.ndarray
    """Whether the node lies where the panel ends, shape (nodes, panels)."""


class PanelIntegral(NamedTuple):
    """An integral over every panel as every node meets it, with its derivatives by X, Y and L, each of shape (nodes, panels)."""

    value: np.ndarray
    by_along: np.ndarray
    by_beside: np.ndarray
    by_length: np.ndarray


def panels_between(nodes: np.ndarray, first: np.ndarray, second: np.ndarray) -> Panels:
    """Panels between two nodes each.

    Parameters
    ----------
    nodes : shape (nodes, 2)
    first, second : numbers of the nodes at which the panels start and end
    """
    between = nodes[second] - nodes[first]
    lengths = np.sqrt((between**2).sum(axis=1))
    tangents = between / lengths[:, None]
    normals = np.stack([-tangents[:, 1], tangents[:, 0]], axis=1)
    away = nodes[:, None] - nodes[first]
    along, beside = (np.einsum("ijk,jk->ij", away, axes) for axes in (tangents, normals))
    apart = (((nodes[:, None] - nodes[own]).real ** 2).sum(axis=2) for own in (first, second))
    starts, ends = (square <= (SAME * lengths.real) ** 2 for square in apart)
    return Panels(tangents, normals, lengths, along, beside, starts, ends)


def vortex_integrals(panels: Panels) -> tuple[PanelIntegral, PanelIntegral]:
    """Weights of the strengths at the start and at the end of every panel in 2 pi times the stream function at every node."""
    x, y, length = panels.along, panels.beside, panels.lengths
    rest = x - length
    first, second, subtended = _logs(panels)
    whole = x * first - rest * second - length + y * subtended
    moment = ((x * x + y * y) * (2 * first - 1) - (rest * rest + y * y) * (2 * second - 1)) / 4
    end = (x * whole - moment) / length
    everything = PanelIntegral(whole, first - second, subtended, second)
    at_end = PanelIntegral(end, whole / length - second, (x * subtended - y * (first - second)) / length, second - end / length)
    log = np.log(length)
    everything = _with_own_nodes(panels, everything, (length * (log - 1), log), (length * (log - 1), log))
    at_end = _with_own_nodes(
        panels, at_end, (length * (log / 2 - 0.25), log / 2 + 0.25), (length * (log / 2 - 0.75), log / 2 - 0.25)
    )
    return PanelIntegral(*(both - one for both, one in zip(everything, at_end, strict=True))), at_end


def source_integral(panels: Panels) -> PanelIntegral:
    """Stream function of a source of strength one along every panel at every node, times 2 pi; it jumps to the right of the panel."""
    x, y, length = panels.along, panels.beside, panels.lengths
    own = panels.starts | panels.ends
    log_first, log_second, _ = _logs(panels)
    first, second = (_angle(np.where(own, 0, each), np.where(own, 1, y)) for each in (x, x - length))
    value = -x * first + y * log_first + (x - length) * second - y * log_second
    found = PanelIntegral(value, second - first, log_first - log_second, -second)
    quarter = np.pi / 2
    return _with_own_nodes(panels, found, (quarter * length, quarter), (-quarter * length, -quarter))


def by_nodes(panels: Panels, first: np.ndarray, second: np.ndarray, sums: PanelIntegral) -> np.ndarray:
    """Derivatives of sums over panels at every node by the places of all nodes.

    Parameters
    ----------
    panels : between the nodes `first` and `second`
    first, second : numbers of the nodes at which the panels start and end; no panels start, or end, at the same node
    sums : what every panel contributes to the sum at every node

    Returns
    -------
    of shape (nodes, nodes, 2): the sum at the first by the coordinates of the second
    """
    _, along, beside, length = (each[..., None] for each in sums)
    x, y, spans = panels.along[..., None], panels.beside[..., None], panels.lengths[:, None]
    of_node = along * panels.tangents + beside * panels.normals
    of_span = (y * along - x * beside) / spans * panels.normals + length * panels.tangents
    nodes = np.arange(len(x))
    found = np.zeros((len(x), len(x), 2), dtype=of_node.dtype)
    found[nodes, nodes] = of_node.sum(axis=1)
    found[:, first] -= of_node + of_span
    found[:, second] += of_span
    return found


def _logs(panels: Panels) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Logarithms of the distances from start and end, and the angle that the panel subtends; zeros at its own nodes."""
    x, y, rest = panels.along, panels.beside, panels.along - panels.lengths
    own = panels.starts | panels.ends
    first, second = (np.log(np.where(own, 1, each * each + y * y)) / 2 for each in (x, rest))
    return first, second, _angle(np.where(own, 0, y * panels.lengths), np.where(own, 1, x * rest + y * y))


def _with_own_nodes(
    panels: Panels, found: PanelIntegral, at_start: tuple[Rate, Rate], at_end: tuple[Rate, Rate]
) -> PanelIntegral:
    """The integral with its value and its derivative by the length at both nodes of each panel, where only the length matters."""
    value, along, beside, length = (np.array(each) for each in found)
    for own, (of_value, of_length) in ((panels.starts, at_start), (panels.ends, at_end)):
        value[own] = np.broadcast_to(of_value, own.shape)[own]
        length[own] = np.broadcast_to(of_length, own.shape)[own]
        along[own] = beside[own] = 0
    return PanelIntegral(value, along, beside, length)


def _angle(sine: np.ndarray, cosine: np.ndarray) -> np.ndarray:
    """Angle atan2(s, c), also of numbers with small imaginary parts."""
    turn = np.arctan2(sine.real, cosine.real)
    if not np.iscomplexobj(sine):
        return turn
    return turn + (sine * np.cos(turn) - cosine * np.sin(turn)) / (cosine * np.cos(turn) + sine * np.sin(turn))
