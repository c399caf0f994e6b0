"""Planar frames for tests of modes and bases: ring, square, cantilever and the wing's skin, with exact derivatives of their matrices."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from preprocessing.builders.curve_mesh import CurveMesh
from preprocessing.builders.skin_geometry import read_geometry
from preprocessing.builders.skin_recipe import SkinRecipe
from preprocessing.elements.beams import PlanarBeam
from preprocessing.elements.section import Section, distribute
from preprocessing.reduction.assembly import Matrices, assemble, interface_point
from preprocessing.reduction.constrained_pencil import ConstrainedPencil

SECTION = Section(youngs_modulus=70000.0, density=2.7e-9, thickness=1.5, width=1000.0)
SKIN = Path(__file__).parents[2] / "models" / "morphing_wing" / "skin.toml"


def matrices(mesh: CurveMesh, section: Section) -> Matrices:
    """All matrices of a mesh of one section, real or complex."""
    patches = distribute(asdict(section), {}, (), len(mesh.connectivity)).patches
    return assemble(PlanarBeam(mesh.nodes, mesh.connectivity, patches)).at(asdict(section))


@dataclass(frozen=True, eq=False)
class Frame:
    """A chain of beam elements, open or closed, whose elements may differ in section by a factor on one parameter."""

    nodes: np.ndarray  # (n_nodes, 2)
    connectivity: np.ndarray  # (n_elements, 2)
    section: Section = SECTION
    factors: np.ndarray | None = None  # (n_elements,) on the parameter `varied`
    varied: str = "thickness"
    points: dict[str, float] | None = None  # name -> place along the chain in elements, 2.3: inside the third element

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """K and M, dense; complex if anything is."""
        stiffness = mass = 0.0
        for elements, section in self._groups():
            found = matrices(CurveMesh(self.nodes, self.connectivity[elements]), section)
            stiffness, mass = stiffness + found.stiffness.toarray(), mass + found.mass.toarray()
        return stiffness, mass

    def interface_rows(self) -> dict[str, np.ndarray]:
        """Rows (3, n) of all points; a complex place gives complex rows."""
        stations, beams = np.arange(len(self.nodes), dtype=float), PlanarBeam(self.nodes, self.connectivity, [])
        rows = {}
        for name, place in (self.points or {}).items():
            point = interface_point(beams, stations, np.eye(3 * len(self.nodes)), np.real(place))
            ahead = 1j * np.imag(place) if np.iscomplexobj(place) else 0.0
            position, rotation = (c[0] + ahead * c[min(1, len(c) - 1)] for c in (point.position, point.rotation))
            rows[name] = np.vstack([position, rotation])
        return rows

    def pencil(self, rows: np.ndarray | None = None) -> ConstrainedPencil:
        stiffness, mass = self.matrices()
        return ConstrainedPencil(stiffness, mass, np.zeros((0, len(mass))) if rows is None else rows)

    def _groups(self):
        if self.factors is None:
            return [(slice(None), self.section)]
        value = getattr(self.section, self.varied)
        groups = [(np.flatnonzero(self.factors == factor), factor) for factor in np.unique(self.factors)]
        return [(elements, replace(self.section, **{self.varied: value * factor})) for elements, factor in groups]


def chain(nodes: np.ndarray, closed: bool = False, **keys) -> Frame:
    first = np.arange(len(nodes) - (not closed))
    return Frame(nodes, np.column_stack([first, (first + 1) % len(nodes)]), **keys)


def ring(n_elements: int, radius: float, **keys) -> Frame:
    angle = 2 * np.pi * np.arange(n_elements) / n_elements
    return chain(radius * np.column_stack([np.cos(angle), np.sin(angle)]), closed=True, **keys)


def square(n_side: int, side: float = 100.0, **keys) -> Frame:
    along = np.arange(n_side) / n_side * side
    zero, full = np.zeros(n_side), np.full(n_side, side)
    corners = [(along, zero), (full, along), (side - along, full), (zero, side - along)]
    return chain(np.vstack([np.column_stack(pair) for pair in corners]), closed=True, **keys)


def cantilever(n_elements: int, length: float = 100.0, angle: float = 0.0, **keys) -> Frame:
    return chain(np.linspace(0, length, n_elements + 1)[:, None] * [np.cos(angle), np.sin(angle)], **keys)


@cache
def wing() -> Frame:
    """The skin of the morphing wing with the interface points of its skin.toml."""
    file = SkinRecipe.read(SKIN).file
    mesh = read_geometry(SKIN, file).mesh
    points = {name: float(place.node) for name, place in file.interface_points.items()}
    return Frame(mesh.nodes, mesh.connectivity, points=points)


def varied(frame: Frame, variable: str, step) -> Frame:
    """The frame at a design changed by the fraction `step` (may be complex) of a natural size.

    Section parameters by name; "element" thickens the element in the first third, "sector" the first five elements; "shape" moves the
    nodes by a smooth field that respects no symmetry; "place" moves the first point, inside an element,
    along the chain by `step` elements.
    """
    n = len(frame.connectivity)
    if variable in ("element", "sector"):
        factors = np.ones(n, dtype=np.result_type(type(step), float))
        factors[n // 3 if variable == "element" else slice(5)] += step
        return replace(frame, factors=factors)
    if variable == "shape":
        size = np.ptp(frame.nodes.real, axis=0).max()
        x, y = frame.nodes.T / size
        field = size * np.column_stack([0.3 * x * y + 0.2 * np.sin(3 * y), 0.4 * x**2 - 0.3 * y])
        return replace(frame, nodes=frame.nodes + step * field)
    if variable == "place":
        first = next(iter(frame.points))
        return replace(frame, points={**frame.points, first: frame.points[first] + step})
    value = getattr(frame.section, variable)
    return replace(frame, section=replace(frame.section, **{variable: value * (1 + step)}))


def pencil_rate(frame: Frame, variable: str) -> ConstrainedPencil:
    """dK, dM by one variable of `varied`, by a complex step of the assembly (no rows)."""
    d = varied(frame, variable, 1e-30j).pencil()
    return ConstrainedPencil(d.stiffness.imag / 1e-30, d.mass.imag / 1e-30, np.zeros_like(d.rows))


def richardson(function, step: float, levels: int = 3) -> np.ndarray:
    """Derivative at zero of a smooth function by central differences with steps halved, extrapolated to order 2 `levels`."""
    found = [(function(h) - function(-h)) / (2 * h) for h in step * 0.5 ** np.arange(levels)]
    for k in range(1, levels):
        found = [fine + (fine - coarse) / (4**k - 1) for coarse, fine in pairwise(found)]
    return found[0]


def relative(ours: np.ndarray, reference: np.ndarray) -> float:
    """Largest difference relative to the largest entry of the reference."""
    return float(np.abs(ours - reference).max() / np.abs(reference).max())
