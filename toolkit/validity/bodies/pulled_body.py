"""Bodies that carry tension: of beam elements by the forces of each, of others by lines that carry the force.

A line of length L along e leads from what holds the frame to a point that is used, or between the two points of a chord. It is longer by
a = e . Z q and so carries the force N = a / c_a, with c_a = e Z K^-1 Z^T e. On the edges of the surface beside it that go along it, each of
slope s across it,

    int w'^2 dx = q^T H q,    H = L mean s^T s

Where the place that holds the body is on both sides of a point, as with both ends clamped, the line goes from end to end. At the part x of
its length the point is held by both sides, and E A / L = x (1 - x) / c_a; the ends keep it as long as it is. A plate that is held all round
has two such lines, and stretches more where it bends more than in the mean: with `PLATE_FACTOR` times that, deflections of a
clamped plate by a force in its middle are those of Timoshenko's, w + 0.443 w^3 / t^2, to a few percent."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolkit.reduced_model.design_point import DesignPoint
from toolkit.solvers.static.static_matrix import StaticArray
from toolkit.system.solution import Solution, design_point, used_interfaces
from toolkit.validity.bodies.carried_force import NO_AXIAL_COMPLIANCE, lines_between, static_deflection, still_points
from toolkit.validity.bodies.geometric_stiffness import Stiffening


class Grown(NamedTuple):
    """What a deflection pulls with at the elastic coordinates, and what it stiffens the body by."""

    forces: np.ndarray  # (n_f,)
    stiffness: Callable[[np.ndarray], StaticArray]  # G_2 (n_f, n_f), where the forces move the coordinates by (n_f,) in the scene


class PulledBody(ABC):
    """A body whose tension is known."""

    @abstractmethod
    def stiffness(self, elastic: np.ndarray) -> StaticArray:
        """G_1 (n_f, n_f) of the forces along it that it knows at elastic coordinates (n_f,)."""

    @abstractmethod
    def grown(self, elastic: np.ndarray) -> Grown:
        """What its lines do at elastic coordinates (n_f,), which grow where they turn."""

    @abstractmethod
    def measures(self, elastic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How much forces along it, and its growth, may stiffen it at most, at coordinates (n_t, n_f): two of shape (n_t,)."""

    @abstractmethod
    def distances(self, elastic: np.ndarray) -> np.ndarray:
        """The largest displacement in its frame at coordinates (n_t, n_f), (n_t,)."""


class StiffnessGrowth(NamedTuple):
    """Growth of the elements of one body, and the forces by which it pulls at the nodes."""

    law: Stiffening
    growth: np.ndarray  # g (n_e,)
    pull: np.ndarray  # B^T S g (n,)

    @property
    def forces(self) -> np.ndarray:
        """Forces - B^T S g of the growth on the elastic coordinates, (n_f,)."""
        found: np.ndarray = -self.law.behind.shapes.T @ self.pull
        return found

    def tension(self, moved: np.ndarray) -> np.ndarray:
        """Axial forces N_2 (n_e,) of the growth, where `forces` move the elastic coordinates by `moved` (n_f,) in the scene."""
        behind = self.law.behind
        u = behind.shapes @ moved
        if not behind.is_full:
            u = u + behind.under(-self.pull[None])[0] - behind.shapes @ self.law.yielding(self.forces)
        stretched: np.ndarray = behind.forms.law[:, 0, 0] * self.growth + behind.axial_forces(u[None])[0]
        return stretched


def growths(law: Stiffening, elastic: np.ndarray) -> np.ndarray:
    """Growth g (n_t, n_e) of the elements at elastic coordinates (n_t, n_f)."""
    u = law.behind.displacements(elastic)[:, law.behind.forms.dofs]
    found: np.ndarray = np.einsum("tep,epq,teq->te", u, law.behind.stiffening[:, 0], u, optimize=True) / 2
    return found


def grown(law: Stiffening, elastic: np.ndarray) -> StiffnessGrowth:
    """Growth of the elements at elastic coordinates (n_f,)."""
    forms, growth = law.behind.forms, growths(law, elastic[None])[0]
    pull = np.zeros(forms.count)
    np.add.at(pull, forms.dofs, np.einsum("ekp,ek->ep", forms.rows, forms.law[:, :, 0] * growth[:, None]))
    return StiffnessGrowth(law, growth, pull)


@dataclass(frozen=True, eq=False)
class PulledChain(PulledBody):
    """A body of beam elements whose geometric stiffness is that of all elements."""

    law: Stiffening

    def stiffness(self, elastic: np.ndarray) -> StaticArray:
        """Geometric stiffness G_1 of axial forces alone."""
        return self.law.of_axial(self.law.forces @ elastic)

    def grown(self, elastic: np.ndarray) -> Grown:
        """Forces and stiffness by the growth of all elements at elastic coordinates (n_f,)."""
        found = grown(self.law, elastic)

        def stiffness(moved: np.ndarray) -> StaticArray:
            return self.law.of_axial(found.tension(moved))

        return Grown(found.forces, stiffness)

    def measures(self, elastic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of N / P by axial forces, and by the growth of lines if they were held everywhere."""
        pulled = np.maximum(elastic @ self.law.forces.T, 0.0) @ self.law.compliances
        stretch = np.square(growths(self.law, elastic)) @ self.law.behind.forms.law[:, 0, 0]
        energy = np.sum(elastic @ self.law.stiffness * elastic, axis=1)
        return pulled, np.divide(2 * stretch, energy, out=np.zeros(len(energy)), where=energy > 0)

    def distances(self, elastic: np.ndarray) -> np.ndarray:
        """Largest displacement of the nodes at coordinates (n_t, n_f), (n_t,)."""
        found: np.ndarray = self.law.behind.distances(self.law.behind.displacements(elastic)).max(axis=1)
        return found


ALONG_COSINE = 0.7
"""Cosine of the angle to a line above which an edge goes along it."""
WIDE_SUPPORT_PART = 0.5
"""Extent along an axis of the points that hold a body, relative to the largest, above which they hold it at two sides."""

PLATE_FACTOR = 3.0
"""Factor of the stiffness of a line, where there are two."""


class ForceLine(NamedTuple):
    """One line through a body, along which forces go."""

    row: np.ndarray  # e Z (n_f,), by which it grows; zero where its ends are held
    stretching: float  # N by a unit of growth, E A / L
    turning: np.ndarray  # H (n_f, n_f)


@dataclass(frozen=True, eq=False)
class PulledLines(PulledBody):
    """A body whose geometric stiffness is that of a few lines."""

    lines: tuple[ForceLine, ...]
    body_stiffness: np.ndarray  # K (n_f, n_f)
    shapes: np.ndarray  # (n, d, n_f) of the points of its surface

    def stiffness(self, elastic: np.ndarray) -> StaticArray:
        """Geometric stiffness G_1 of the forces along the lines."""
        found: np.ndarray = sum((each.stretching * (each.row @ elastic) * each.turning for each in self.lines), self._none)
        return found

    def grown(self, elastic: np.ndarray) -> Grown:
        """Forces and stiffness by the growth of the lines at elastic coordinates (n_f,)."""
        growth = [elastic @ each.turning @ elastic / 2 for each in self.lines]
        forces = -sum((each.stretching * g * each.row for each, g in zip(self.lines, growth, strict=True)), 0 * elastic)

        def stiffness(moved: np.ndarray) -> StaticArray:
            pairs = zip(self.lines, growth, strict=True)
            found: np.ndarray = sum((each.stretching * (g + each.row @ moved) * each.turning for each, g in pairs), self._none)
            return found

        return Grown(forces, stiffness)

    def measures(self, elastic: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of N / P by forces along the lines, and by the growth of the lines if they were held."""
        pulled, stretch = np.zeros(len(elastic)), np.zeros(len(elastic))
        for each in self.lines:
            softness = np.trace(static_deflection(self.body_stiffness, each.turning))
            pulled += np.maximum(each.stretching * (elastic @ each.row), 0.0) * softness
            stretch += each.stretching * (np.sum(elastic @ each.turning * elastic, axis=1) / 2) ** 2
        energy = np.sum(elastic @ self.body_stiffness * elastic, axis=1)
        return pulled, np.divide(2 * stretch, energy, out=np.zeros(len(energy)), where=energy > 0)

    def distances(self, elastic: np.ndarray) -> np.ndarray:
        """Largest displacement of the points of the surface at coordinates (n_t, n_f), (n_t,)."""
        found: np.ndarray = np.linalg.norm(np.einsum("pdf,tf->tpd", self.shapes, elastic), axis=2).max(axis=1)
        return found

    @property
    def _none(self) -> np.ndarray:
        return np.zeros_like(self.body_stiffness)


class Shown(NamedTuple):
    """The surface of a body in space, or its outline in the plane."""

    places: np.ndarray  # (n, d)
    shapes: np.ndarray  # (n, d, n_f)
    edges: np.ndarray  # (n_edges, 2)


class Edges(NamedTuple):
    """Edges beside a line."""

    places: np.ndarray  # x (n,) of their middles, in parts of the line
    weights: np.ndarray  # (n,) of their lengths, which make one
    slopes: np.ndarray  # s (n, d, n_f)


def pulled_lines(solution: Solution, body: str) -> PulledLines | None:
    """Lines of a body; None where its model holds no edges, or no line in it has a length."""
    design = design_point(solution.system.scene, body, "surface", "outline", "interfaces")
    key = (PulledLines, tuple(used_interfaces(solution.system.scene, body)))
    if key not in design.kept:
        shown = shown_of(design)
        lines = () if shown is None else tuple(_lines(solution, body, design, shown))
        stiffness = np.real(design.value("stiffness"))
        design.kept[key] = PulledLines(lines, stiffness, shown.shapes) if lines and shown else None
    found: PulledLines | None = design.kept[key]
    return found


def shown_of(design: DesignPoint) -> Shown | None:
    surface, outline = design.model.surface, design.model.outline
    if surface is not None:
        sides = np.concatenate([surface.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
        edges = np.unique(np.sort(sides, axis=1), axis=0) if len(sides) else surface.lines
    elif outline is not None:
        edges = outline.edges[:, [0, -1]]
    else:
        return None
    position = np.real(design.value("surface.position" if surface is not None else "outline.position"))
    return Shown(position[:, :, 0], position[:, :, 1:], edges) if len(edges) else None


def _lines(solution: Solution, body: str, design: DesignPoint, shown: Shown) -> Iterator[ForceLine]:
    """Longest line that ends at a point, or the lines from end to end."""
    stiffness, still = np.real(design.value("stiffness")), still_points(shown.places, shown.shapes)
    ends = [(motion, start) for _, start, motion in lines_between(solution, body, still)]
    seen = [each for each in ends if compliance_along(stiffness, each[0], each[0][:, 0]) > 0]
    if seen:
        motion, start = max(seen, key=lambda each: float(np.linalg.norm(each[0][:, 0])))
        yield from _line(shown, start, motion[:, 0], motion[:, 1:], 1 / compliance_along(stiffness, motion, motion[:, 0]))
    elif still is not None:
        found = list(_held_around(solution, body, design, shown, still))
        factor = PLATE_FACTOR if len(found) > 1 else 1.0
        yield from (each._replace(stretching=factor * each.stretching) for each in found)


def _held_around(solution: Solution, body: str, design: DesignPoint, shown: Shown, still: np.ndarray) -> Iterator[ForceLine]:
    """Lines from end to end of the points that hold the body, through the used point nearest to their middle."""
    middle, stiffness = still.mean(axis=0), np.real(design.value("stiffness"))
    motions = [np.real(design.interface(name).here[0]) for name in used_interfaces(solution.system.scene, body)]
    motions = [each for each in motions if np.any(each[:, 1:])]
    if not motions:
        return
    motion = min(motions, key=lambda each: float(np.linalg.norm(each[:, 0] - middle)))
    axes = np.linalg.svd(still - middle, full_matrices=False)[2]
    places = (still - middle) @ axes.T
    low, extent = places.min(axis=0), np.ptp(places, axis=0)
    parts = (axes @ (motion[:, 0] - middle) - low) / np.where(extent > 0, extent, 1.0)
    for k, axis in enumerate(axes):
        away = np.linalg.norm(motion[:, 0] - middle - axis * (axis @ (motion[:, 0] - middle)))
        compliance = compliance_along(stiffness, motion, axis)
        if extent[k] > WIDE_SUPPORT_PART * extent.max() and 0 < parts[k] < 1 and away < extent[k] / 2 and compliance > 0:
            part = float(parts[k])
            held = np.zeros((len(axis), len(stiffness)))
            yield from _line(shown, middle + axis * low[k], axis * extent[k], held, part * (1 - part) / compliance)


def compliance_along(stiffness: np.ndarray, motion: np.ndarray, side: np.ndarray) -> float:
    """Compliance c_a of a point along a side; zero where the basis does not see it."""
    along = side / np.linalg.norm(side)
    row, moved = along @ motion[:, 1:], motion[:, 1:]
    found = float(row @ static_deflection(stiffness, row))
    largest = float(np.linalg.eigvalsh(moved @ static_deflection(stiffness, moved.T))[-1])
    return found if found > NO_AXIAL_COMPLIANCE * largest else 0.0


def _line(shown: Shown, start: np.ndarray, side: np.ndarray, moved: np.ndarray, stretching: float) -> Iterator[ForceLine]:
    """A line with the edges beside it; none where no edge goes along it."""
    found = edges_beside(shown, start, side)
    if found is not None:
        flat = (found.slopes * np.sqrt(found.weights)[:, None, None]).reshape(-1, found.slopes.shape[2])
        length = float(np.linalg.norm(side))
        yield ForceLine(side / length @ moved, stretching, length * (flat.T @ flat))


def edges_beside(shown: Shown, start: np.ndarray, side: np.ndarray) -> Edges | None:
    """Edges of a surface that go along a line; None without any."""
    length = float(np.linalg.norm(side))
    along = side / length
    first, last = shown.edges.T
    lengths = np.linalg.norm(shown.places[last] - shown.places[first], axis=1)
    ahead = (shown.places[last] - shown.places[first]) @ along
    place = ((shown.places[last] + shown.places[first]) / 2 - start) @ along / length
    beside = (np.abs(ahead) > ALONG_COSINE * lengths) & (place > 0) & (place < 1)
    if not beside.any():
        return None
    weights = np.abs(ahead[beside]) / np.abs(ahead[beside]).sum()
    slopes = (shown.shapes[last[beside]] - shown.shapes[first[beside]]) / ahead[beside, None, None]
    return Edges(place[beside], weights, slopes - along[None, :, None] * np.einsum("d,edf->ef", along, slopes)[:, None])
