"""Refusal of reduced models that are incomplete or cannot be physical; whatever is wrong is named by its place in the file."""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.foundation.errors import ModelFileError
from toolkit.foundation.units import LARGEST, SMALLEST, UNIT_SYSTEMS
from toolkit.reduced_model.definiteness import positive_definite
from toolkit.reduced_model.dependence import Derivatives, Polynomial
from toolkit.reduced_model.elements import LOCAL, SPATIAL_LOCAL, Elements, SpatialElements
from toolkit.reduced_model.entry_scales import EntryScale, entry_factors
from toolkit.reduced_model.model import (
    InterfacePoint,
    Invariants,
    Mesh,
    Outline,
    ReducedModel,
    Shape,
    StressPoints,
    generalized_mass,
    of_elements,
)
from toolkit.reduced_model.parts.interior import Interior
from toolkit.reduced_model.parts.pieces import PieceLoads, Pieces
from toolkit.reduced_model.parts.spin import SPIN_STIFFENING, Spin
from toolkit.reduced_model.spatial_model import (
    PAIRS,
    SURFACE_POSITION,
    SpatialInvariants,
    Surface,
    SurfaceLoad,
    spatial_generalized_mass,
)
from toolkit.reduced_model.thin_arrays import listed, places, sparing

RIGID = 1e-13
"""Smallest eigenvalue of the mass matrix, scaled to a unit diagonal, that is more than round-off; the wing's skin has 1e-7, and with 2000
elements 4e-13."""

ROUND_OFF = 1e-9
"""Largest relative difference of two numbers that should be equal; sums over some hundred nodes leave 1e-13."""

OF_STIFFNESS = ("stiffness", "damping", "stress_operator")
"""Invariants that are not made of mass."""

MAGNITUDE = LARGEST**3
"""Largest number of a model, a product of some that the user gave; products of these still are floating-point numbers."""

HIGHEST_POWER = 20

PARTS_WITH_ITEMS = ("interfaces", "shape", "surface", "surface_loads", "elements", "spin", "piece_loads")
"""Parts of which arrays can depend on parameters, besides the invariants."""

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
    SpatialInvariants: {
        "stiffness": "ff", "damping": "ff", "mass": "", "first_moment": "3z", "second_moment": "6zz", "stress_operator": "scf",
    },
    Surface: {"position": "p3z", "triangles": "t3", "lines": "l2"},
    SurfaceLoad: {"force": "3", "moment": "33z"},
    Spin: {"stiffening": "gff"},
    Pieces: {"element": "p", "position": "p3y"},
    PieceLoads: {"force": "e3", "moment": "e33y"},
}  # fmt: skip
SPATIAL_POINT = {**SHAPES[InterfacePoint], "position": "k3z", "rotation": "k3z"}
"""One letter per axis: f elastic coordinates, z = 1 + f, s stress points, r = 3 nodes, u of one element, w = 1 + u, in space v and y;
others are free."""


def letters_of(part: Any) -> dict[str, str]:
    """Letters of the axes of every array of one object of a model."""
    return SPATIAL_POINT if isinstance(part, InterfacePoint) and part.rotation.ndim == 3 else SHAPES[type(part)]


Sizes = dict[str, int]


def check(model: ReducedModel, path: Path, before: Container[str] = ()) -> None:
    """Refuse a model whose parts disagree or whose matrices are not physical.

    Parameters
    ----------
    before : parts that were checked by themselves when they were read before

    Raises
    ------
    ModelFileError
        It names the file and the group, dataset or attribute.
    """
    _check_attributes(model, path)
    sizes: Sizes = {"2": 2, "3": 3, "4": 4, "6": 6, "u": LOCAL, "w": 1 + LOCAL, "v": SPATIAL_LOCAL, "y": 1 + SPATIAL_LOCAL}
    _fit_all(path, "invariants", model.invariants, sizes)
    if "invariants" not in before:
        _check_matrices(model.invariants, path)
    _check_derivatives(model, path, sizes)
    _check_affine(model, path, sizes)
    for name, point in (model.interfaces or {}).items():
        _fit_all(path, f"interfaces/{name}", point, sizes)
        low, high = point.arc_length_range
        if not low <= point.arc_length <= high:
            _refuse(path, f"interfaces/{name}/arc_length", f"is outside its range [{low:g}, {high:g}]")
    for group in ("surface_loads", "piece_loads"):
        for name, load in (getattr(model, group) or {}).items():
            _fit_all(path, f"{group}/{name}", load, sizes)
    for part in ("stress", "shape", "mesh", "outline", "interior", "elements", "surface", "spin", "pieces"):
        if getattr(model, part) is not None:
            _fit_all(path, part, getattr(model, part), sizes)
    if model.spin is not None and "spin" not in before:
        _check_spin(model.spin.stiffening, 1 if model.dimension == 2 else len(PAIRS), path)
    _check_numbers(model, path)


def _check_attributes(model: ReducedModel, path: Path) -> None:
    if model.dimension not in (2, 3):
        _refuse(path, "dimension", f"is {model.dimension} instead of 2 or 3")
    if model.units not in UNIT_SYSTEMS:
        _refuse(path, "units", f"is {model.units!r} instead of one of {', '.join(UNIT_SYSTEMS)}")
    texts = {name: getattr(model, name) for name in ("reference_condition", "basis", "input_hash")}
    for group in ("nominal_units", "writers", "inputs", "source"):
        texts |= {f"{group}/{name}": value for name, value in getattr(model, group).items()}
    for name, value in texts.items():
        if not isinstance(value, str):
            _refuse(path, name, f"is {value!r} instead of a text")
    if foreign := set(model.source) - set(model.inputs):
        _refuse(path, f"source/{min(foreign)}", "is not among its inputs")
    for group in ("changes", "left_out", "stress_errors", "stress_error_at", "face_errors"):
        for name, value in getattr(model, group).items():
            if not isinstance(value, (int, float)):
                _refuse(path, f"{group}/{name}", f"is {value!r} instead of a number")
    for name, value in model.nominal.items():
        if not isinstance(value, (int, float)) or not (value == 0 or SMALLEST <= abs(value) <= LARGEST):
            _refuse(path, f"nominal/{name}", f"is {value!r} instead of a number that is zero or from {SMALLEST:g} to {LARGEST:g}")
        if name not in model.nominal_units:
            _refuse(path, f"nominal_units/{name}", "is missing")


def _check_matrices(inv: Invariants | SpatialInvariants, path: Path) -> None:
    own: dict[str, tuple[np.ndarray, int]]
    scales = _sizes(inv)
    if isinstance(inv, SpatialInvariants):
        own = {f"second_moment[{k}]": (inv.second_moment[k], 1) for k in range(3)}
        root = scales["second_moment"].column
        scales |= {f"second_moment[{k}]": EntryScale(root, root) for k in range(3)}
        place, mass = "second_moment", spatial_generalized_mass(inv)
    else:
        own = {"inertia": (inv.inertia, 1), "gyroscopic": (inv.gyroscopic, -1)}
        place, mass = "inertia", generalized_mass(inv)
    for name, (matrix, sign) in {**own, "stiffness": (inv.stiffness, 1), "damping": (inv.damping, 1)}.items():
        entry, difference = listed(abs(sparing(matrix) - sign * sparing(matrix).T))
        if np.any(difference > ROUND_OFF * scales[name].at(entry)):
            _refuse(path, f"invariants/{name}", "is not " + ("symmetric" if sign > 0 else "antisymmetric"))
    if not positive_definite(mass - RIGID * np.eye(len(mass))):
        _refuse(
            path,
            f"invariants/{place}",
            "gives an indefinite mass matrix: the basis duplicates a rigid motion of the frame",
        )


def _check_spin(stiffening: np.ndarray, count: int, path: Path) -> None:
    """One symmetric matrix in the plane, six in space."""
    if len(stiffening) != count:
        _refuse(path, SPIN_STIFFENING.replace(".", "/"), f"has {len(stiffening)} matrices instead of {count}")
    if np.abs(stiffening - stiffening.swapaxes(1, 2)).max(initial=0) > ROUND_OFF * np.abs(stiffening).max(initial=0):
        _refuse(path, SPIN_STIFFENING.replace(".", "/"), "is not symmetric")


def _sizes(inv: Invariants | SpatialInvariants) -> dict[str, EntryScale]:
    """What a difference in every entry of the invariants is compared with.

    Whatever is a matter of mass can vanish as a whole, but for round-off, and is compared with what it could be. Stiff bodies
    leave more round-off in their soft motions than these are stiff: stiffness, damping and stress, which do not vanish, are
    compared with their largest entry.
    """
    return entry_factors(inv) | {name: _largest(getattr(inv, name)) for name in OF_STIFFNESS}


def _largest(array: np.ndarray) -> EntryScale:
    """The largest entry for all."""
    rows = sparing(array)
    return EntryScale(
        np.full(len(array.reshape(-1, array.shape[-1])), abs(rows).max() if array.size else 0.0), np.ones(array.shape[-1])
    )


def _check_derivatives(model: ReducedModel, path: Path, sizes: Sizes) -> None:
    for item, derivatives in {**(model.derivatives or {}), **(model.element_derivatives or {})}.items():
        place = f"{'element_' * of_elements(item)}derivatives/{item}"
        _fit_all(path, place, derivatives, sizes)
        _numbers_below(path, f"{place}/parameter", derivatives.parameter, len(model.nominal), "parameters")
        _numbers_below(path, f"{place}/entry", derivatives.entry, _size(model, path, place, item), "entries")


def _check_affine(model: ReducedModel, path: Path, sizes: Sizes) -> None:
    """Polynomials of the parameters, which give the invariants at the nominal design."""
    p, sizes_of = np.array(list(model.nominal.values())), _sizes(model.invariants)
    for item, polynomial in {**(model.affine or {}), **(model.element_affine or {})}.items():
        place = f"{'element_' * of_elements(item)}affine/{item}"
        names = [
            *SHAPES[type(model.invariants)],
            SPIN_STIFFENING,
            SURFACE_POSITION,
            *(f"elements.{name}" for kind in (Elements, SpatialElements) for name in SHAPES[kind]),
        ]
        if item not in names:
            _refuse(path, place, f"is the name of no invariant; there are {', '.join(names)}")
        _fit_all(path, place, polynomial, sizes)
        _numbers_below(path, f"{place}/factor", polynomial.factor + 1, len(p) + 1, "parameters")
        _numbers_below(path, f"{place}/power", np.abs(polynomial.power), HIGHEST_POWER + 1, "powers")
        _numbers_below(path, f"{place}/term", polynomial.term, len(polynomial.factor), "terms")
        _numbers_below(path, f"{place}/entry", polynomial.entry, _size(model, path, place, item), "entries")
        part = item.split(".")[0]
        if part in PARTS_WITH_ITEMS and getattr(model, part) is None:
            continue
        nominal = model.item(item)
        here = places(nominal, polynomial.entry)
        difference = np.abs(polynomial.on(here)(p, len(here)) - nominal.ravel()[here])
        size = sizes_of[item] if item in sizes_of else _largest(nominal)
        if not np.all(difference <= ROUND_OFF * size.at(here)):
            _refuse(path, f"{place}/value", f"differs from invariants/{item} at the nominal design")


def _size(model: ReducedModel, path: Path, place: str, item: str) -> int:
    """Number of entries of an item; without bound if it is in a part that was not loaded."""
    if item.split(".")[0] in PARTS_WITH_ITEMS and getattr(model, item.split(".")[0]) is None:
        return np.iinfo(np.int64).max
    try:
        return model.item(item).size
    except (AttributeError, KeyError, IndexError, TypeError):
        _refuse(path, place, "is the name of nothing in the file that could depend on parameters")
        raise


def _numbers_below(path: Path, place: str, numbers: np.ndarray, end: int, what: str) -> None:
    """Refuse what cannot be the number of one of `end` things."""
    if numbers.dtype.kind not in "iu" or numbers.min(initial=0) < 0 or numbers.max(initial=-1) >= end:
        _refuse(path, place, f"holds numbers of {what} that do not exist")


def _check_numbers(model: ReducedModel, path: Path) -> None:
    """Numbers of nodes, elements, ends and fibres that pictures index with."""
    mesh, stress, outline, surface = model.mesh, model.stress, model.outline, model.surface
    elements = model.elements
    if elements is not None and not np.isin(elements.connectivity, np.arange(len(elements.nodes))).all():
        _refuse(path, "elements/connectivity", f"names nodes other than 0 to {len(elements.nodes) - 1}")
    if isinstance(elements, SpatialElements) and not np.isin(elements.held, np.arange(len(elements.nodes))).all():
        _refuse(path, "elements/held", f"names nodes other than 0 to {len(elements.nodes) - 1}")
    _check_pieces(model, path)
    for name in ("triangles", "lines"):
        if surface is not None and not np.isin(getattr(surface, name), np.arange(len(surface.position))).all():
            _refuse(path, f"surface/{name}", f"names points other than 0 to {len(surface.position) - 1}")
    if outline is not None and not np.isin(outline.edges, np.arange(len(outline.position))).all():
        _refuse(path, "outline/edges", f"names points other than 0 to {len(outline.position) - 1}")
    if model.interior is not None:
        _numbers_below(path, "interior/triangles", model.interior.triangles, len(model.interior.position), "points")
        _numbers_below(path, "interior/modulus", model.interior.modulus, len(model.nominal), "parameters")
    if mesh is not None and not np.isin(mesh.connectivity, np.arange(len(mesh.nodes))).all():
        _refuse(path, "mesh/connectivity", f"names nodes other than 0 to {len(mesh.nodes) - 1}")
    if stress is None:
        return
    for name, allowed in (("end", (0, 1)), ("fibre", (-1, 1))):
        if not np.isin(getattr(stress, name), allowed).all():
            _refuse(path, f"stress/{name}", f"holds numbers other than {allowed[0]} and {allowed[1]}")
    if mesh is not None and not np.isin(stress.element, np.arange(len(mesh.connectivity))).all():
        _refuse(path, "stress/element", f"names elements other than 0 to {len(mesh.connectivity) - 1}")


def _check_pieces(model: ReducedModel, path: Path) -> None:
    """Stress of all components of every point one after the other, and points of the surface by elements that exist."""
    elements, points, components = model.elements, *model.invariants.stress_operator.shape[:2]
    if isinstance(elements, SpatialElements):
        if len(elements.stress_operator) != points * components:
            _refuse(
                path, "elements/stress_operator", f"has {len(elements.stress_operator)} rows instead of {points * components}"
            )
        if model.pieces is not None:
            _numbers_below(path, "pieces/element", model.pieces.element, len(elements.connectivity), "elements")
        if model.stress is not None:
            _numbers_below(path, "stress/element", model.stress.element, len(elements.connectivity), "elements")
    for name, load in (model.piece_loads or {}).items():
        if isinstance(elements, SpatialElements) and len(load.force) != len(elements.connectivity):
            _refuse(path, f"piece_loads/{name}/force", f"has {len(load.force)} rows instead of {len(elements.connectivity)}")
    if model.face_errors and not ({"least", "largest"} < model.face_errors.keys()):
        _refuse(path, "face_errors", 'lacks "least", "largest" or the errors by single forces')
    if model.pieces is not None and model.surface is not None and len(model.pieces.element) != len(model.surface.position):
        _refuse(
            path, "pieces/element", f"tells {len(model.pieces.element)} points of {len(model.surface.position)} of the surface"
        )


def _fit_all(path: Path, place: str, part: Any, sizes: Sizes) -> None:
    """Fit all arrays of one object; its free letters are its own, f, z and s are known to all after the invariants."""
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
        _refuse(path, place, f"holds values that are not finite numbers, or are beyond {MAGNITUDE:g}")
    if array.ndim != len(letters) or any(
        sizes.setdefault(letter, n) != n for letter, n in zip(letters, array.shape, strict=True)
    ):
        expected = ", ".join(str(sizes.get(letter, "any")) for letter in letters)
        _refuse(path, place, f"has shape {array.shape} instead of ({expected})")


def _refuse(path: Path, place: str, problem: str) -> None:
    raise ModelFileError(f"{str(path)!r}: {place} {problem}. Build it again with ffrf-preprocess.")
