"""Shapes of all arrays of a reduced model, how large their entries could be, and the refusal of arrays that do not fit.

Mass, stiffness and damping are sums of squares, so that by the inequality of Cauchy and Schwarz

    |G_ij|, |H_ij|, |Q_ab,ij| <= sqrt(G_ii G_jj)       |N_ai| <= sqrt(m G_ii)       |K_ij| <= sqrt(K_ii K_jj)       |D_ij| <=
    sqrt(D_ii D_jj)

with G the sum of the Q_aa in space. A matrix that vanishes, such as H of a straight beam's bending modes, holds nothing but
round-off: compared with itself it would be neither zero nor antisymmetric.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from toolkit.foundation.errors import ModelFileError
from toolkit.foundation.units import LARGEST
from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial, is_sparse, sparing
from toolkit.reduced_model.model import InterfacePoint, Invariants, Mesh, Outline, Shape, StressPoints
from toolkit.reduced_model.parts import (
    BeamSections,
    Elements,
    Interior,
    LeftOutShapes,
    PieceLoads,
    Pieces,
    SpatialElements,
    SpatialInvariants,
    Spin,
    Surface,
    SurfaceLoad,
)

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Matrix

Part: TypeAlias = (
    Invariants
    | SpatialInvariants
    | InterfacePoint
    | SparsePolynomial
    | Derivatives
    | StressPoints
    | Shape
    | Mesh
    | Outline
    | Interior
    | Elements
    | SpatialElements
    | BeamSections
    | Surface
    | SurfaceLoad
    | Spin
    | LeftOutShapes
    | Pieces
    | PieceLoads
)
"""An object of a reduced model, whose fields are arrays."""


def refuse(path: Path, place: str, problem: str) -> None:
    """Refuse a model for what is wrong at one place in its file."""
    raise ModelFileError(f"{str(path)!r}: {place} {problem}. Build it again with ffrf-preprocess.")


def numbers_below(path: Path, place: str, numbers: np.ndarray, end: int, what: str) -> None:
    """Refuse numbers that cannot count from 0 up to, but without, `end`."""
    if numbers.dtype.kind not in "iu" or numbers.min(initial=0) < 0 or numbers.max(initial=-1) >= end:
        refuse(path, place, f"holds numbers of {what} that do not exist")


MAGNITUDE = LARGEST**3
"""Largest number of a model, a product of some that the user gave; products of these still are floating-point numbers."""

SHAPES: dict[type, dict[str, str]] = {
    Invariants: {
        "stiffness": "ff", "damping": "ff", "mass": "", "first_moment": "2z", "inertia": "zz", "gyroscopic": "zz",
        "stress_operator": "sf",
    },
    InterfacePoint: {"arc_length": "", "arc_length_range": "2", "position": "k2z", "rotation": "kz"},
    SparsePolynomial: {"factor": "tj", "power": "tj", "term": "n", "entry": "n", "value": "n"},
    Derivatives: {"parameter": "n", "entry": "n", "value": "n"},
    StressPoints: {"element": "s", "end": "s", "fibre": "s"},
    Shape: {"position": "k2z", "target": "k2", "arc_length": "k"},
    Mesh: {"nodes": "k2", "connectivity": "e2", "recovery": "rz", "outline": "o2", "target_outline": "t2"},
    Outline: {"position": "p2z", "edges": "e3"},
    Interior: {"position": "p2z", "triangles": "t3", "stress": "p4f", "modulus": ""},
    Elements: {
        "nodes": "k2", "connectivity": "e2", "mass": "e", "first_moment": "e2w", "inertia": "eww", "gyroscopic": "eww",
        "stiffness": "euu", "damping": "euu", "stress_operator": "su",
    },
    SpatialElements: {
        "nodes": "k3", "connectivity": "e2", "held": "h", "mass": "e", "first_moment": "e3y", "second_moment": "e6yy",
        "stiffness": "evv", "damping": "evv", "stress_operator": "nv",
    },
    BeamSections: {
        "axis": "e3", "stress_per_strain": "e", "axial_stiffness": "e", "bending_stiffness": "ep", "torsional_stiffness": "e",
        "shear_stiffness": "e", "mass_per_length": "e", "fibre_distance": "sp",
    },
    SpatialInvariants: {
        "stiffness": "ff", "damping": "ff", "mass": "", "first_moment": "3z", "second_moment": "6zz", "stress_operator": "scf",
    },
    Surface: {"position": "p3z", "triangles": "t3", "lines": "l2"},
    SurfaceLoad: {"force": "3", "moment": "33z"},
    Spin: {"stiffening": "gff"},
    LeftOutShapes: {"compliance": "qq", "stress_operator": "nq"},
    Pieces: {"element": "p", "position": "p3y"},
    PieceLoads: {"force": "e3", "moment": "e33y"},
}  # fmt: skip
SPATIAL_POINT = {**SHAPES[InterfacePoint], "position": "k3z", "rotation": "k3z"}
"""One letter per axis: f elastic coordinates, z = 1 + f, s stress points, r = 3 nodes, u of one element, w = 1 + u, in space v and y;
q loads; others are free."""

Sizes = dict[str, int]


def letters_of(part: Part) -> dict[str, str]:
    """Letters of the axes of every array of a model's object."""
    return SPATIAL_POINT if isinstance(part, InterfacePoint) and part.rotation.ndim == 3 else SHAPES[type(part)]


def fit_all(path: Path, place: str, part: Part, sizes: Sizes) -> None:
    """Refuse arrays of one object whose shapes disagree with their letters.

    An object's free letters are its own; f, z and s are known to all after the invariants.
    """
    own = dict(sizes)
    for name, letters in letters_of(part).items():
        _fit(path, f"{place}/{name}", getattr(part, name), letters, own)
        if name == "stiffness":
            own["z"] = 1 + own["f"]
        if name == "nodes":
            own["r"] = 3 * own["k"]
    if isinstance(part, (Invariants, SpatialInvariants)):
        sizes.update(own)


def _fit(path: Path, place: str, array: np.ndarray, letters: str, sizes: Sizes) -> None:
    """Refuse an array whose shape disagrees with its letters or whose values are no finite numbers; note the size of new letters."""
    if array.dtype.kind not in "iuf" or not (np.abs(array) <= MAGNITUDE).all():
        refuse(path, place, f"holds values that are not finite numbers, or are beyond {MAGNITUDE:g}")
    if array.ndim != len(letters) or any(
        sizes.setdefault(letter, n) != n for letter, n in zip(letters, array.shape, strict=True)
    ):
        expected = ", ".join(str(sizes.get(letter, "any")) for letter in letters)
        refuse(path, place, f"has shape {array.shape} instead of ({expected})")


class EntryScale(NamedTuple):
    """Sizes row_i column_j of an array's entries; i counts the places of all axes but the last, j those of the last."""

    row: np.ndarray
    column: np.ndarray

    def at(self, entry: np.ndarray) -> np.ndarray:
        """Sizes at places in the flattened array."""
        row, column = np.divmod(entry, len(self.column))
        return self.row[row] * self.column[column]


def entry_scales(inv: Invariants | SpatialInvariants) -> dict[str, np.ndarray]:
    """Largest size that each entry of every invariant could have, by name, in the shape of the array."""
    found = {name: np.outer(scale.row, scale.column) for name, scale in entry_factors(inv).items()}
    return {name: scale.reshape(getattr(inv, name).shape) for name, scale in found.items()}


def entry_factors(inv: Invariants | SpatialInvariants) -> dict[str, EntryScale]:
    """Largest sizes as factors, for invariants in arrays, or in sparse matrices with all axes but the last in one.

    The stress operator is no product of squares: its entries are measured by the largest ones of their columns and rows.
    """
    inertia = _diagonal_of_inertia(inv)
    root, first = np.sqrt(np.abs(inertia)), np.sqrt(np.abs(inv.mass * inertia))
    planes = {name: _planes(getattr(inv, name), len(inertia)) for name in inv.moments}
    return {
        "mass": EntryScale(np.abs(np.atleast_1d(inv.mass)), np.ones(1)),
        "first_moment": EntryScale(np.ones(len(inv.first_moment)), first),
        **{name: EntryScale(np.tile(root, count), root) for name, count in planes.items()},
        **{name: _of_squares(getattr(inv, name)) for name in ("stiffness", "damping")},
        "stress_operator": _of_rows(inv.stress_operator),
    }


def _diagonal_of_inertia(inv: Invariants | SpatialInvariants) -> np.ndarray:
    """Diagonal of the inertia matrix G; in space of the sum of the Q_aa."""
    if isinstance(inv, SpatialInvariants):
        z = inv.second_moment.shape[-1]
        moments = inv.second_moment if inv.second_moment.ndim == 2 else inv.second_moment.reshape(-1, z)
        return sum((moments[k * z : (k + 1) * z].diagonal() for k in range(1, 3)), moments[:z].diagonal())
    return inv.inertia.diagonal()


def _planes(moment: Matrix, z: int) -> int:
    """Number of matrices (z, z) stacked in an array."""
    return int(np.prod(moment.shape)) // z**2


def _of_squares(matrix: Matrix) -> EntryScale:
    root = np.sqrt(np.abs(matrix.diagonal()))
    return EntryScale(root, root)


def _of_rows(array: Matrix) -> EntryScale:
    """Largest entry of each column times the largest entry of each row in parts of that of its column."""
    width = array.shape[-1]
    rows = array.tocsr() if is_sparse(array) else sparing(array)
    if not is_sparse(rows):
        sizes = np.abs(rows)
        return EntryScale(_part(sizes, sizes.max(axis=0, initial=0.0)).max(axis=1, initial=0.0), sizes.max(axis=0, initial=0.0))
    size, column = np.abs(rows.data), rows.indices
    largest = np.zeros(width)
    np.maximum.at(largest, column, size)
    parts = np.zeros(rows.shape[0])
    np.maximum.at(parts, np.repeat(np.arange(rows.shape[0]), np.diff(rows.indptr)), _part(size, largest[column]))
    return EntryScale(parts, largest)


def _part(size: np.ndarray, of: np.ndarray) -> np.ndarray:
    return np.divide(size, of, out=np.zeros_like(size), where=of > 0)
