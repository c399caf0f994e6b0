"""The reduced model of a body in pieces: each is an element with two nodes, from which scenes make parts with frames of their own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import NamedTuple, TypeVar

import numpy as np
from scipy.linalg import eigh

from preprocessing.builders.cut_mesh import ENDS, CutMesh, PieceBodies
from preprocessing.builders.discrete_body import DiscreteBody
from preprocessing.builders.reduced_body import MeshError, mesh_error, reduced_body, reduced_solid
from preprocessing.mesh.faces import BoundaryFaces
from preprocessing.reduction.basis import BasisChoice
from preprocessing.reduction.chosen_basis import clamped_in_tangent_frame
from toolkit.reduced_model.cut_part import symmetric
from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial
from toolkit.reduced_model.model import InterfacePoint, Invariants, ReducedModel, StressPoints
from toolkit.reduced_model.parts import (
    PAIRS,
    SPATIAL_ELEMENT_COORDINATES,
    PieceLoads,
    Pieces,
    SpatialElements,
    SpatialInvariants,
    Surface,
    SurfaceLoad,
)
from toolkit.reduced_model.questions import EXTREMES
from toolkit.reduced_model.shapes import SHAPES, letters_of

LEFT_OUT = -1
"""Number along an axis that stands for what is not kept."""


class PiecePlacement(NamedTuple):
    """Place (n,) of every entry of a piece's item in the target, or `LEFT_OUT`, and the number of entries there."""

    to: np.ndarray
    size: int


class PlacedArrays(NamedTuple):
    """Arrays, derivatives and polynomials of items, by name, as far as there are any."""

    arrays: dict[str, np.ndarray]
    derivatives: dict[str, Derivatives]
    affine: dict[str, SparsePolynomial]


def placement(array: np.ndarray, letters: str, numbers: Mapping[str, np.ndarray], lengths: Mapping[str, int]) -> PiecePlacement:
    """Placement of an array whose axes have letters.

    `numbers` are those along axes that change, and `lengths` the lengths of these axes in the target.
    """
    along = [numbers.get(letter, np.arange(n)) for letter, n in zip(letters, array.shape, strict=True)]
    shape = tuple(lengths.get(letter, n) for letter, n in zip(letters, array.shape, strict=True))
    grids = np.meshgrid(*along, indexing="ij") if along else []
    if not grids:
        return PiecePlacement(np.zeros(1, int), 1)
    kept = np.all([grid >= 0 for grid in grids], axis=0)
    flat = np.ravel_multi_index(tuple(np.where(kept, grid, 0) for grid in grids), shape) if array.size else np.zeros(0, int)
    return PiecePlacement(np.where(kept.ravel(), flat.ravel(), LEFT_OUT), int(np.prod(shape)))


def in_row(number: int, size: int, count: int) -> PiecePlacement:
    """Placement of an item with so many entries, of the piece with a number, one piece after the other."""
    return PiecePlacement(number * size + np.arange(size), count * size)


def placed(pieces: Sequence[ReducedModel], places: Iterable[Mapping[str, PiecePlacement]]) -> PlacedArrays:
    """Sums of the pieces' items in their places.

    Parameters
    ----------
    places : of each piece, item -> placement
    """
    arrays, slopes, terms = dict[str, np.ndarray](), dict[str, list[Derivatives]](), dict[str, list[SparsePolynomial]]()
    for piece, own in zip(pieces, places, strict=True):
        for item, place in own.items():
            values = np.ravel(piece.item(item))
            here = place.to >= 0
            np.add.at(arrays.setdefault(item, np.zeros(place.size)), place.to[here], values[here])
            if item in piece.all_derivatives:
                slopes.setdefault(item, []).append(_moved(piece.all_derivatives[item], place.to))
            if item in piece.all_polynomials:
                terms.setdefault(item, []).append(_moved(piece.all_polynomials[item], place.to))
    return PlacedArrays(
        arrays, {k: sum(each[1:], each[0]) for k, each in slopes.items()}, {k: _sum(each) for k, each in terms.items()}
    )


def letters_of_items(invariants: Invariants | SpatialInvariants) -> dict[str, str]:
    """Letters of the axes of all invariants, see `toolkit.reduced_model.shapes`."""
    letters = letters_of(invariants)
    return {f.name: letters[f.name] for f in fields(invariants)}


Dependence = TypeVar("Dependence", Derivatives, SparsePolynomial)


def _moved(found: Dependence, to: np.ndarray) -> Dependence:
    """Derivatives or polynomial with entries in their new places, without those that are left out."""
    here = to[found.entry] >= 0
    along = {name: getattr(found, name)[here] for name in ("parameter", "term") if name in vars(found)}
    return replace(found, entry=to[found.entry[here]], value=found.value[here], **along)


def _sum(each: Sequence[SparsePolynomial]) -> SparsePolynomial:
    """Sum of polynomials, whose terms are given the same number of factors."""
    width = max(one.factor.shape[1] for one in each)
    starts = np.cumsum([0, *(len(one.factor) for one in each[:-1])])

    def padded(table: np.ndarray, blank: int) -> np.ndarray:
        return np.pad(table, ((0, 0), (0, width - table.shape[1])), constant_values=blank)

    return SparsePolynomial(
        np.concatenate([padded(one.factor, -1) for one in each]),
        np.concatenate([padded(one.power, 0) for one in each]),
        np.concatenate([one.term + start for one, start in zip(each, starts, strict=True)]),
        np.concatenate([one.entry for one in each]),
        np.concatenate([one.value for one in each]),
    )


MOTIONS = SPATIAL_ELEMENT_COORDINATES // 2
"""Number of motions of an end: along x, y and z, and about them."""
CLAMPED = 0
"""Number of the end that the frame of the body is tied to."""


def columns_of_end(number: int) -> np.ndarray:
    """Columns of [1; q_f] of the body that are the motions of an end, (6,); `LEFT_OUT` at the clamp."""
    return np.full(MOTIONS, LEFT_OUT) if number == CLAMPED else 1 + MOTIONS * (number - 1) + np.arange(MOTIONS)


def columns_of_piece(number: int) -> np.ndarray:
    """Column of [1; q_f] of the body for each of those of a piece, (13,)."""
    return np.concatenate([[0], columns_of_end(number), columns_of_end(number + 1)])


class PiecePressures(NamedTuple):
    """Unit pressures on the body's surfaces and on those of its pieces, with their derivatives."""

    surface_loads: dict[str, SurfaceLoad]
    piece_loads: dict[str, PieceLoads]
    derivatives: dict[str, Derivatives]  # of the former
    element_derivatives: dict[str, Derivatives]  # of the latter


def pressures(pieces: Sequence[ReducedModel]) -> PiecePressures:
    """Unit pressures on all surfaces that the pieces share."""
    loads, count = [each.surface_loads or {} for each in pieces], len(pieces)
    names = [*loads[0]]
    whole, every = placed(pieces, _pressure_in_body(loads)), placed(pieces, _pressure_in_row(loads))
    return PiecePressures(
        {name: SurfaceLoad(*_arrays(whole, name, (), 1 + MOTIONS * count)) for name in names},
        {name: PieceLoads(*_arrays(every, name, (count,), 1 + SPATIAL_ELEMENT_COORDINATES)) for name in names},
        whole.derivatives,
        {item.replace("surface_loads", "piece_loads", 1): each for item, each in every.derivatives.items()},
    )


def _arrays(found: PlacedArrays, name: str, first: tuple[int, ...], width: int) -> tuple[np.ndarray, np.ndarray]:
    force, moment = (found.arrays[f"surface_loads.{name}.{key}"] for key in ("force", "moment"))
    return force.reshape(*first, 3), moment.reshape(*first, 3, 3, width)


def _pressure_in_body(loads: Sequence[Mapping[str, SurfaceLoad]]) -> Iterator[dict[str, PiecePlacement]]:
    """Placements of every piece's loads on the coordinates of the body."""
    lengths = {"z": 1 + MOTIONS * len(loads)}
    for k, own in enumerate(loads):
        numbers = {"z": columns_of_piece(k)}
        yield {
            f"surface_loads.{name}.{key}": placement(getattr(load, key), letters, numbers, lengths)
            for name, load in own.items()
            for key, letters in SHAPES[SurfaceLoad].items()
        }


def _pressure_in_row(loads: Sequence[Mapping[str, SurfaceLoad]]) -> Iterator[dict[str, PiecePlacement]]:
    """Placements of every piece's loads one after the other."""
    for k, own in enumerate(loads):
        yield {
            f"surface_loads.{name}.{key}": in_row(k, getattr(load, key).size, len(loads))
            for name, load in own.items()
            for key in SHAPES[SurfaceLoad]
        }


ROUND_OFF = 1e-6
"""Error below which it is round-off of both compliances."""


def judged_by_uncut(body: DiscreteBody, ends: Mapping[str, int], stiffness: np.ndarray) -> tuple[dict[str, float], MeshError]:
    """Errors of the faces between pieces, as `ReducedModel.face_errors`, and of the mesh.

    Parameters
    ----------
    body : uncut
    ends : interface point -> number of its end, the clamp's is zero
    stiffness : of the pieces, on the motions of all ends but the clamped one
    """
    solid = reduced_solid(body, BasisChoice("static"))
    shapes, m = solid.shapes, body.mesh.motions
    here = np.concatenate([m * (ends[name] - 1) + np.arange(m) for name in shapes.points])
    in_pieces = symmetric(np.linalg.inv(stiffness)[np.ix_(here, here)])
    uncut = symmetric(np.linalg.inv(shapes.columns.T @ (solid.stiffness @ shapes.columns)))
    extremes = eigh(in_pieces, uncut, eigvals_only=True)[[0, -1]] - 1
    loads = [f"{what} {axis} at {name}" for name in shapes.points for what in ("force", "moment") for axis in "xyz"]
    found = {
        **dict(zip(EXTREMES, extremes, strict=True)),
        **dict(zip(loads, np.diag(in_pieces) / np.diag(uncut) - 1, strict=True)),
    }
    errors = {name: float(error) if abs(error) > ROUND_OFF else 0.0 for name, error in found.items()}
    return errors, mesh_error(solid)


class PieceSurface(NamedTuple):
    """Surface of the body, with the piece that each of its points belongs to."""

    owner: np.ndarray  # (n_points,) number of the piece
    rows: list[np.ndarray]  # of every point of the surface of each piece its number among those of the body, or `LEFT_OUT`
    triangles: np.ndarray

    def parts(self, pieces: Sequence[ReducedModel], width: int, n_stress: int) -> tuple[Surface, Pieces, StressPoints]:
        """Parts of the reduced model: surface, pieces, and stress points, one to each surface point or none."""
        surface, own = np.zeros((len(self.owner), 3, width)), np.zeros((len(self.owner), 3, 1 + SPATIAL_ELEMENT_COORDINATES))
        for k, (piece, rows) in enumerate(zip(pieces, self.rows, strict=True)):
            here, columns = rows >= 0, columns_of_piece(k)
            assert piece.surface is not None
            moved, kept = piece.surface.position[here], columns >= 0
            own[rows[here]] = moved
            surface[np.ix_(rows[here], np.arange(3), columns[kept])] = moved[:, :, kept]
        told = self.owner[:n_stress]
        points = StressPoints(told, np.zeros_like(told), np.ones_like(told))
        return Surface(surface, self.triangles, np.zeros((0, 2), int)), Pieces(self.owner, own), points


def piece_surface(found: PieceBodies) -> PieceSurface:
    """Points of the surface of the uncut body, shared among the pieces."""
    cut, whole = found.cut, found.cut.named.boundary
    assert isinstance(whole, BoundaryFaces)
    points = whole.points
    owner = np.full(len(points), LEFT_OUT)
    for k, piece in reversed([*enumerate(cut.pieces)]):
        owner[np.isin(points, piece.nodes)] = k
    rows = []
    for k, (piece, body) in enumerate(zip(cut.pieces, found.bodies, strict=True)):
        assert isinstance(body.boundary, BoundaryFaces)
        mine = piece.nodes[body.boundary.points]
        place = np.searchsorted(points, mine).clip(max=len(points) - 1)
        rows.append(np.where((points[place] == mine) & (owner[place] == k), place, LEFT_OUT))
    return PieceSurface(owner, rows, whole.triangles)


def places_of_ends(pieces: Sequence[ReducedModel]) -> PlacedArrays:
    """Item `nodes`, (3 n_ends,): each end where the piece behind it has it, the last one where the last piece has it."""
    places, count = [], len(pieces) + 1
    for k, piece in enumerate(pieces):
        own = {}
        for number, name in zip((k, k + 1), ENDS, strict=True):
            item = f"interfaces.{name}.position"
            to = np.full(piece.item(item).shape, LEFT_OUT)
            if number == k or number == count - 1:
                to[0, :, 0] = 3 * number + np.arange(3)
            own[item] = PiecePlacement(to.ravel(), 3 * count)
        places.append(own)
    found = placed(pieces, places)
    slopes = [each for each in found.derivatives.values() if len(each.entry)]
    nodes = np.sum([*found.arrays.values()], axis=0)
    return PlacedArrays({"nodes": nodes}, {"nodes": sum(slopes[1:], slopes[0])} if slopes else {}, {})


def numbers_of_points(cut: CutMesh) -> Iterator[tuple[str, int]]:
    """Interface points in the order of the file, and the numbers of their ends."""
    numbers = {end.point: k for k, end in enumerate(cut.ends) if end.point}
    yield from ((name, numbers[name]) for name in cut.named.file.interface_points)


def interfaces_of_ends(cut: CutMesh, nodes: np.ndarray, width: int) -> dict[str, InterfacePoint]:
    """Interface points at the ends, whose motions are coordinates of the body, or none at the clamp."""
    found = {}
    for name, number in numbers_of_points(cut):
        z = np.zeros((MOTIONS, width))
        z[:3, 0] = nodes.reshape(-1, 3)[number]
        if number != CLAMPED:
            z[:, columns_of_end(number)] = np.eye(MOTIONS)
        found[name] = InterfacePoint(np.zeros(()), np.zeros(2), *z.reshape(2, 1, 3, width))
    return found


def derivatives_of_points(cut: CutMesh, nodes: PlacedArrays, width: int) -> dict[str, Derivatives]:
    """Derivatives of the interface points' places, by what moves the ends."""
    found = {}
    for name, number in numbers_of_points(cut):
        for slope in nodes.derivatives.values():
            here = slope.entry // 3 == number
            if np.any(here):
                entry = width * (slope.entry[here] % 3)
                found[f"interfaces.{name}.position"] = Derivatives(slope.parameter[here], entry, slope.value[here])
    return found


COMPONENTS = 6
"""Number of stress components at a point."""


def joined_model(found: PieceBodies) -> ReducedModel:
    """Reduced model that follows from the pieces, each reduced to the motions of its ends by constraint modes."""
    cut, surface = found.cut, piece_surface(found)
    choice, units = BasisChoice("static"), cut.named.file.units
    pieces = [reduced_body(replace(body, elastic=None), choice, "", units) for body in found.bodies]  # the uncut mesh is judged
    n_stress = len(surface.owner) if len(pieces[0].invariants.stress_operator) else 0
    stress = [{"s": rows if n_stress else rows[:0]} for rows in surface.rows]  # where the stress points of every piece go
    whole, every = _in_body(pieces, stress, n_stress), _in_row(pieces, stress, n_stress)
    invariants, nodes = _invariants(whole, len(pieces), n_stress), places_of_ends(pieces)
    width, pressed = invariants.first_moment.shape[1], pressures(pieces)
    drawn, pieces_of_surface, points = surface.parts(pieces, width, n_stress)
    face_errors, errors_of_mesh = judged_by_uncut(found.whole, dict(numbers_of_points(cut)), invariants.stiffness)
    return replace(
        pieces[0],  # of which units, parameters and writers are those of the body
        reference_condition=clamped_in_tangent_frame(f"the nodes of {cut.named.file.clamp and cut.named.file.clamp.words}"),
        basis=_words(cut),
        invariants=invariants,
        derivatives=whole.derivatives | derivatives_of_points(cut, nodes, width) | pressed.derivatives,
        affine=whole.affine,
        interfaces=interfaces_of_ends(cut, nodes.arrays["nodes"], width),
        stress=points,
        elements=_elements(every, nodes, len(pieces), n_stress),
        element_derivatives=_of_elements({**every.derivatives, **nodes.derivatives}) | pressed.element_derivatives,
        element_affine=_of_elements(every.affine),
        surface=drawn,
        surface_loads=pressed.surface_loads,
        pieces=pieces_of_surface,
        piece_loads=pressed.piece_loads,
        left_out={"interface": min(each.left_out["interface"] for each in pieces)},  # what each leaves out moves none of its ends
        face_errors=face_errors,
        **errors_of_mesh._asdict(),
    )


def _words(cut: CutMesh) -> str:
    groups, faces = ", ".join(piece.group for piece in cut.pieces), cut.named.file.pieces and cut.named.file.pieces.faces
    return f"differentiated: all motions of the ends of the pieces {groups}, {faces} faces between them"


Rows = Sequence[Mapping[str, np.ndarray]]
"""Arrays of every piece, by their names."""


def _in_body(pieces: Sequence[ReducedModel], stress: Rows, n_stress: int) -> PlacedArrays:
    """Invariants of the body: sums of those of the pieces on its coordinates."""
    lengths, places = {"z": 1 + MOTIONS * len(pieces), "f": MOTIONS * len(pieces), "s": n_stress}, []
    for k, piece in enumerate(pieces):
        inv, columns = piece.invariants, columns_of_piece(k)
        numbers = {"z": columns, "f": np.where(columns[1:] >= 0, columns[1:] - 1, LEFT_OUT), **stress[k]}
        letters = letters_of_items(inv)
        places.append({item: placement(getattr(inv, item), letters[item], numbers, lengths) for item in letters})
    return placed(pieces, places)


def _in_row(pieces: Sequence[ReducedModel], stress: Rows, n_stress: int) -> PlacedArrays:
    """Invariants of every piece one after the other; the stress of every point once."""
    places = []
    for k, piece in enumerate(pieces):
        inv, own = piece.invariants, dict[str, PiecePlacement]()
        for item, letters in letters_of_items(inv).items():
            array = getattr(inv, item)
            own[item] = in_row(k, array.size, len(pieces))
            if item == "stress_operator":
                own[item] = placement(array, letters, stress[k], {"s": n_stress})
        places.append(own)
    return placed(pieces, places)


def _invariants(whole: PlacedArrays, count: int, n_stress: int) -> SpatialInvariants:
    n_f = MOTIONS * count
    shapes = {
        "mass": (),
        "first_moment": (3, 1 + n_f),
        "second_moment": (len(PAIRS), 1 + n_f, 1 + n_f),
        "stiffness": (n_f, n_f),
        "damping": (n_f, n_f),
        "stress_operator": (n_stress, COMPONENTS, n_f),
    }
    return SpatialInvariants(**{name: whole.arrays[name].reshape(shape) for name, shape in shapes.items()})


def _elements(every: PlacedArrays, nodes: PlacedArrays, count: int, n_stress: int) -> SpatialElements:
    width = 1 + SPATIAL_ELEMENT_COORDINATES
    shapes = {
        "mass": (count,),
        "first_moment": (count, 3, width),
        "second_moment": (count, len(PAIRS), width, width),
        "stiffness": (count, SPATIAL_ELEMENT_COORDINATES, SPATIAL_ELEMENT_COORDINATES),
        "damping": (count, SPATIAL_ELEMENT_COORDINATES, SPATIAL_ELEMENT_COORDINATES),
        "stress_operator": (n_stress * COMPONENTS, SPATIAL_ELEMENT_COORDINATES),
    }
    connectivity = np.column_stack([np.arange(count), np.arange(count) + 1])
    sums = {name: every.arrays[name].reshape(shape) for name, shape in shapes.items()}
    return SpatialElements(nodes.arrays["nodes"].reshape(-1, 3), connectivity, np.array([CLAMPED]), **sums)


def _of_elements(items: Mapping[str, Dependence]) -> dict[str, Dependence]:
    return {f"elements.{name}": each for name, each in items.items()}
