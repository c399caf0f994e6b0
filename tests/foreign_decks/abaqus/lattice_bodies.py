"""Random small bodies on a lattice: where the nodes are, what the elements are, and which nodes lie on which side, by construction."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise, permutations, product
from random import Random
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

Point = tuple[int, int, int]
"""A point of the lattice: corners of cells have even coordinates, middles of their edges odd ones."""
CUBE: tuple[Point, ...] = ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2))
EDGES = {
    "tetra10": ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    "wedge15": ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    "hexahedron20": ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)),
    "triangle6": ((0, 1), (1, 2), (2, 0)),
    "quad8": ((0, 1), (1, 2), (2, 3), (3, 0)),
    "line3": ((0, 1),),
}
"""Kind -> edges whose middle nodes follow the corners, in this order (element library of Abaqus; CalculiX has the same)."""
QUADRATIC = {
    "tetra": "tetra10", "wedge": "wedge15", "hexahedron": "hexahedron20", "triangle": "triangle6", "quad": "quad8", "line": "line3",
}  # fmt: skip
FACES = {
    "tetra": ("123", "142", "243", "341"),
    "wedge": ("123", "465", "1452", "2563", "3641"),
    "hexahedron": ("1234", "5876", "1562", "2673", "3784", "4851"),
    "triangle": ("12", "23", "31"),
    "quad": ("12", "23", "34", "41"),
}
"""Kind -> corners of S1, S2 and so on, as the manuals number them from 1."""
FLAT = {2: "line", 3: "triangle", 4: "quad"}


class Cell(NamedTuple):
    """An element on the lattice."""

    kind: str
    points: tuple[Point, ...]  # corners, then middles


@dataclass
class Body:
    """Elements on points of a lattice, and the places of these points."""

    plane: bool
    counts: Point  # cells along each direction
    cells: list[Cell]
    places: dict[Point, np.ndarray]
    volume: float | None  # of the plane an area; None where layers are turned
    regular: bool  # whether neighbours along one direction are equally far from each other
    shift: np.ndarray = field(default_factory=lambda: np.zeros(3))  # from every layer to the next one
    axis: np.ndarray = field(default_factory=lambda: np.zeros(3))  # through the origin, about which it is turned after that
    degrees: float = 0.0

    @property
    def far(self) -> Point:
        """The corner of the lattice across its origin."""
        return (2 * self.counts[0], 2 * self.counts[1], 2 * self.counts[2])


def random_body(rng: Random, generated: bool, plane: bool) -> Body:
    """A body of few cells: hexahedra and wedges, tetrahedra, or elements of the plane, with or without middle nodes.

    Parameters
    ----------
    rng : source of all choices
    generated : whether nodes and elements are to repeat evenly, so that a deck can generate them
    plane : whether it is one of the plane
    """
    counts: Point = (rng.randint(1, 3), rng.randint(1, 2), 0 if plane else rng.randint(1, 2))
    cells = [*(_plane_cells(rng, counts, generated) if plane else _solid_cells(rng, counts, generated))]
    if not generated and rng.random() < 0.5:
        cells = [with_middles(cell) for cell in cells]
    if generated:
        points = {(2 * i, 2 * j, 2 * k) for i, j, k in product(*(range(n + 1) for n in counts))}
    else:
        points = {point for cell in cells for point in cell.points}
        cells = [turned_about(rng, cell) for cell in cells]
    if generated and not plane and rng.random() < 0.4:
        return _swept(rng, counts, cells, points)
    return _affine(rng, plane, counts, cells, points, generated)


def _affine(rng: Random, plane: bool, counts: Point, cells: list[Cell], points: set[Point], even: bool) -> Body:
    """The lattice stretched, turned and sheared."""
    axes = [_stations(rng, n, even) for n in counts]
    matrix = np.eye(3)
    if rng.random() < 0.5:
        matrix = np.eye(3) + np.array([[0, rng.uniform(-0.4, 0.4), 0], [0, 0, 0], [0, 0, 0]])
        if not plane:
            matrix = random_rotation(rng) @ matrix
    origin = np.array([rng.choice([0.0, rng.uniform(-5, 5)]) for _ in range(3)])
    places = {p: origin + matrix @ [axes[a][p[a]] for a in range(3)] for p in sorted(points)}
    extents = [axes[a][2 * counts[a]] - axes[a][0] for a in range(3)]
    volume = float(np.prod(extents[: 2 if plane else 3])) * float(np.linalg.det(matrix))
    step = np.zeros(3) if plane else places[0, 0, 2] - places[0, 0, 0] if (0, 0, 2) in places else np.zeros(3)
    return Body(plane, counts, cells, places, volume, even, step)


def _swept(rng: Random, counts: Point, cells: list[Cell], points: set[Point]) -> Body:
    """Layers of a lattice, each turned against the one before about an axis and moved."""
    axes = [_stations(rng, n, True) for n in counts[:2]]
    axis, degrees = random_rotation(rng)[:, 0], rng.choice([5.0, 12.5, 30.0])
    turn = Rotation.from_rotvec(axis * np.deg2rad(degrees)).as_matrix()
    shift = np.array([rng.uniform(0.5, 1.0), 0.25, rng.uniform(1.0, 2.0)])
    places = {p: np.array([3.0 + axes[0][p[0]], axes[1][p[1]], 0.5]) for p in sorted(points) if p[2] == 0}
    for k in range(counts[2]):
        places |= {(p[0], p[1], 2 * k + 2): turn @ (place + shift) for p, place in list(places.items()) if p[2] == 2 * k}
    return Body(False, counts, cells, places, None, True, shift, axis, degrees)


def _stations(rng: Random, count: int, even: bool) -> list[float]:
    """Coordinates of the lattice along one direction: those of middles are means."""
    step = rng.choice([0.5, 1.0, 0.1, rng.uniform(0.3, 2.0)])
    corners = [0.0]
    for _ in range(count):
        corners.append(corners[-1] + (step if even else step * rng.choice([1, 1, 2, 0.75])))
    middles = [(a + b) / 2 for a, b in pairwise(corners)]
    return [x for pair in zip(corners, [*middles, 0.0], strict=True) for x in pair][:-1]


def _solid_cells(rng: Random, counts: Point, alike: bool) -> Iterator[Cell]:
    """Tetrahedra, or columns of hexahedra and of wedges."""
    tetra, wedges = rng.random() < 0.3, rng.random() < 0.3
    columns = {ij: wedges if alike else rng.random() < 0.3 for ij in product(range(counts[0]), range(counts[1]))}
    for i, j, k in product(*(range(n) for n in counts)):
        corners = [(2 * i + x, 2 * j + y, 2 * k + z) for x, y, z in CUBE]
        if tetra:
            yield from _tetrahedra((2 * i, 2 * j, 2 * k))
        elif columns[i, j]:
            yield from (Cell("wedge", tuple(corners[m] for m in each)) for each in ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)))
        else:
            yield Cell("hexahedron", tuple(corners))


def _tetrahedra(first: Point) -> Iterator[Cell]:
    """Six tetrahedra of a cell, which fit those of its neighbours: along its edges from corner to corner."""
    for order in permutations(range(3)):
        path = [np.array(first)]
        for axis in order:
            path.append(path[-1] + 2 * np.eye(3, dtype=int)[axis])
        if np.linalg.det([each - path[0] for each in path[1:]]) < 0:
            path[1], path[2] = path[2], path[1]
        yield Cell("tetra", tuple((int(p[0]), int(p[1]), int(p[2])) for p in path))


def _plane_cells(rng: Random, counts: Point, alike: bool) -> Iterator[Cell]:
    triangles = rng.random() < 0.4
    for i, j in product(range(counts[0]), range(counts[1])):
        corners = [(2 * i + x, 2 * j + y, 0) for x, y, _ in CUBE[:4]]
        if triangles if alike else rng.random() < 0.4:
            yield from (Cell("triangle", tuple(corners[m] for m in each)) for each in ((0, 1, 2), (0, 2, 3)))
        else:
            yield Cell("quad", tuple(corners))


def with_middles(cell: Cell) -> Cell:
    """The same element with nodes in the middles of its edges."""
    kind = QUADRATIC[cell.kind]
    return Cell(kind, (*cell.points, *(_middle(cell.points[a], cell.points[b]) for a, b in EDGES[kind])))


def _middle(a: Point, b: Point) -> Point:
    return ((a[0] + b[0]) // 2, (a[1] + b[1]) // 2, (a[2] + b[2]) // 2)


def linear(cell: Cell) -> Cell:
    """The same element without middle nodes."""
    kind = next((plain for plain, quadratic in QUADRATIC.items() if quadratic == cell.kind), cell.kind)
    corners = {"tetra": 4, "wedge": 6, "hexahedron": 8, "triangle": 3, "quad": 4, "line": 2}[kind]
    return Cell(kind, cell.points[:corners])


def turned_about(rng: Random, cell: Cell) -> Cell:
    """The same element, whose numbering begins at another corner."""
    plain = linear(cell)
    order = rng.choice(_ROTATIONS[plain.kind])
    found = Cell(plain.kind, tuple(plain.points[k] for k in order))
    return found if plain.kind == cell.kind else with_middles(found)


def _cube_rotations() -> list[tuple[int, ...]]:
    """The 24 numberings of a hexahedron that keep its orientation."""
    centred = np.array(CUBE) - 1
    found = []
    for axes, signs in product(permutations(range(3)), product((1, -1), repeat=3)):
        matrix = np.eye(3, dtype=int)[list(axes)] * np.array(signs)[:, None]
        if round(np.linalg.det(matrix)) == 1:
            found.append(tuple(int(np.flatnonzero((centred == row).all(axis=1))[0]) for row in centred @ matrix.T))
    return found


def _even(order: tuple[int, ...]) -> bool:
    return round(np.linalg.det(np.eye(len(order))[list(order)])) == 1


_ROTATIONS: dict[str, list[tuple[int, ...]]] = {
    "hexahedron": _cube_rotations(),
    "tetra": [order for order in permutations(range(4)) if _even(order)],
    "wedge": [(0, 1, 2, 3, 4, 5), (1, 2, 0, 4, 5, 3), (2, 0, 1, 5, 3, 4), (3, 5, 4, 0, 2, 1), (5, 4, 3, 2, 1, 0)],
    "triangle": [(0, 1, 2), (1, 2, 0), (2, 0, 1)],
    "quad": [(0, 1, 2, 3), (1, 2, 3, 0), (2, 3, 0, 1), (3, 0, 1, 2)],
}


def sides(cell: Cell) -> Iterator[tuple[int, Cell]]:
    """Number, from 1, and nodes of every face of a solid, or edge of a plane element."""
    plain = linear(cell)
    for number, corners in enumerate(FACES[plain.kind], start=1):
        face = Cell(FLAT[len(corners)], tuple(plain.points[int(k) - 1] for k in corners))
        yield number, face if plain.kind == cell.kind else with_middles(face)


def random_rotation(rng: Random) -> np.ndarray:
    """A matrix that turns space."""
    axis = np.array([rng.gauss(0, 1) for _ in range(3)])
    return np.asarray(Rotation.from_rotvec(axis / np.linalg.norm(axis) * rng.uniform(0.2, 3.0)).as_matrix())
