"""Shapes of all arrays of a reduced model, one letter per axis, and the refusal of arrays that disagree."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from toolkit.foundation.units import LARGEST
from toolkit.reduced_model.checks.refusal import refuse
from toolkit.reduced_model.dependence import Derivatives, Polynomial
from toolkit.reduced_model.elements import Elements, SpatialElements
from toolkit.reduced_model.model import InterfacePoint, Invariants, Mesh, Outline, Shape, StressPoints
from toolkit.reduced_model.parts.interior import Interior
from toolkit.reduced_model.parts.left_out_shapes import LeftOutShapes
from toolkit.reduced_model.parts.pieces import PieceLoads, Pieces
from toolkit.reduced_model.parts.sections import BeamSections
from toolkit.reduced_model.parts.spin import Spin
from toolkit.reduced_model.spatial_model import SpatialInvariants, Surface, SurfaceLoad

MAGNITUDE = LARGEST**3
"""Largest number of a model, a product of some that the user gave; products of these still are floating-point numbers."""

SHAPES: dict[Any, dict[str, str]] = {
    Invariants: {
        "stiffness": "ff", "damping": "ff", "mass": "", "first_moment": "2z", "inertia": "zz", "gyroscopic": "zz",
        "stress_operator": "sf",
    },
    InterfacePoint: {"arc_length": "", "arc_length_range": "2", "position": "k2z", "rotation": "kz"},
    Polynomial: {"factor": "tj", "power": "tj", "term": "n", "entry": "n", "value": "n"},
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


def letters_of(part: Any) -> dict[str, str]:
    """Letters of the axes of every array of a model's object."""
    return SPATIAL_POINT if isinstance(part, InterfacePoint) and part.rotation.ndim == 3 else SHAPES[type(part)]


def fit_all(path: Path, place: str, part: Any, sizes: Sizes) -> None:
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
