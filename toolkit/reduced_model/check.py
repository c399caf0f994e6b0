"""Refusal of reduced models that are incomplete or cannot be physical; whatever is wrong is named by its place in the file."""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path

import numpy as np

from toolkit.foundation.errors import ModelFileError
from toolkit.foundation.units import LARGEST, SMALLEST, UNIT_SYSTEMS
from toolkit.reduced_model.composition import read_composition
from toolkit.reduced_model.dependence import is_thin, listed, places, sparing
from toolkit.reduced_model.frozen_basis import richer_model
from toolkit.reduced_model.model import Invariants, ReducedModel, dependence_group, generalized_mass
from toolkit.reduced_model.parts import (
    ELEMENT_COORDINATES,
    PAIRS,
    SPATIAL_ELEMENT_COORDINATES,
    SPIN_STIFFENING,
    SURFACE_POSITION,
    BeamSections,
    Elements,
    SpatialElements,
    SpatialInvariants,
    count_of_loads,
    spatial_generalized_mass,
)
from toolkit.reduced_model.shapes import SHAPES, EntryScale, Sizes, entry_factors, fit_all, numbers_below, refuse


def positive_definite(matrix: np.ndarray) -> bool:
    """Whether a symmetric matrix is positive definite.

    By Cholesky's factors; a large matrix that is zero nearly everywhere by the pivots of Gauss' elimination in a sparing order.

    A symmetric matrix is positive definite if and only if all pivots of an elimination down its diagonal are positive
    (Sylvester).
    """
    if not is_thin(matrix):
        try:
            np.linalg.cholesky(matrix)
        except np.linalg.LinAlgError:
            return False
        return True
    return _pivots_are_positive(matrix)


def _pivots_are_positive(matrix: np.ndarray) -> bool:
    from scipy.sparse import csc_array  # only large models are worth its start
    from scipy.sparse.linalg import splu

    try:
        found = splu(csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # a pivot is zero
        return False
    return bool(np.array_equal(found.perm_r, found.perm_c) and np.all(found.U.diagonal() > 0))


SMALLEST_MASS_EIGENVALUE = 1e-13
"""Smallest eigenvalue of the mass matrix, scaled to a unit diagonal, that is more than round-off; the wing's skin has 1e-7, and with 2000
elements 4e-13."""

ROUND_OFF = 1e-9
"""Largest relative difference of two numbers that should be equal; sums over some hundred nodes leave 1e-13."""

OF_STIFFNESS = ("stiffness", "damping", "stress_operator")
"""Invariants that are not made of mass."""


def check_matrices(inv: Invariants | SpatialInvariants, path: Path) -> None:
    """Refuse invariants that are not symmetric but for round-off, or whose mass is not positive definite."""
    own: dict[str, tuple[np.ndarray, int]]
    scales = entry_sizes(inv)
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
            refuse(path, f"invariants/{name}", "is not " + ("symmetric" if sign > 0 else "antisymmetric"))
    if not positive_definite(mass - SMALLEST_MASS_EIGENVALUE * np.eye(len(mass))):
        refuse(
            path,
            f"invariants/{place}",
            "gives an indefinite mass matrix: the basis duplicates a rigid motion of the frame",
        )


def check_spin(stiffening: np.ndarray, count: int, path: Path) -> None:
    """Refuse spin stiffening that is not one symmetric matrix in the plane, or six in space."""
    if len(stiffening) != count:
        refuse(path, SPIN_STIFFENING.replace(".", "/"), f"has {len(stiffening)} matrices instead of {count}")
    if np.abs(stiffening - stiffening.swapaxes(1, 2)).max(initial=0) > ROUND_OFF * np.abs(stiffening).max(initial=0):
        refuse(path, SPIN_STIFFENING.replace(".", "/"), "is not symmetric")


def check_left_out(model: ReducedModel, path: Path) -> None:
    """Refuse a compliance that is not symmetric, or has another number of loads than the body can have."""
    found, points = model.left_out_shapes, model.interfaces
    if found is None:
        return
    wanted = None if points is None else count_of_loads(len(points), model.dimension, model.n_f)
    if wanted is not None and len(found) != wanted:
        refuse(path, "left_out_shapes/compliance", f"has {len(found)} loads instead of {wanted}")
    if len(found.stress_operator) != model.invariants.stress_operator[..., 0].size:
        refuse(path, "left_out_shapes/stress_operator", "has another number of rows than invariants/stress_operator")
    scale = np.sqrt(np.diag(found.compliance).clip(0.0))
    if np.any(np.abs(found.compliance - found.compliance.T) > ROUND_OFF * np.outer(scale, scale)):
        refuse(path, "left_out_shapes/compliance", "is not symmetric")


def check_sections(model: ReducedModel, path: Path) -> None:
    """Refuse sections whose stiffness or mass is not positive, or that bend in another number of planes than the beams."""
    found = model.sections
    assert found is not None
    for name in ("stress_per_strain", "axial_stiffness", "bending_stiffness", "mass_per_length"):
        if not (getattr(found, name) > 0).all():
            refuse(path, f"sections/{name}", "holds numbers that are not positive")
    for name in ("torsional_stiffness", "shear_stiffness"):
        if not (getattr(found, name) >= 0).all():
            refuse(path, f"sections/{name}", "holds negative numbers")
    if found.bending_stiffness.shape[1] != model.dimension - 1:
        refuse(
            path, "sections/bending_stiffness", f"has {found.bending_stiffness.shape[1]} columns instead of {model.dimension - 1}"
        )


def entry_sizes(inv: Invariants | SpatialInvariants) -> dict[str, EntryScale]:
    """Sizes that differences in the entries of the invariants are compared with.

    Whatever is a matter of mass can vanish as a whole, but for round-off, and is compared with what it could be. Stiff bodies
    leave more round-off in their soft motions than these are stiff: stiffness, damping and stress, which do not vanish, are
    compared with their largest entry.
    """
    return entry_factors(inv) | {name: largest(getattr(inv, name)) for name in OF_STIFFNESS}


def largest(array: np.ndarray) -> EntryScale:
    """Entry scale that is the array's largest entry everywhere."""
    rows = sparing(array)
    return EntryScale(
        np.full(len(array.reshape(-1, array.shape[-1])), abs(rows).max() if array.size else 0.0), np.ones(array.shape[-1])
    )


PARALLEL_SINE = 1e-6
"""Sine of the angle between an element and the axis of its section below which they are parallel."""


def check_indices(model: ReducedModel, path: Path) -> None:
    """Refuse numbers of nodes, elements, points, ends and fibres that do not exist."""
    mesh, stress, outline, surface = model.mesh, model.stress, model.outline, model.surface
    elements = model.elements
    if elements is not None and not np.isin(elements.connectivity, np.arange(len(elements.nodes))).all():
        refuse(path, "elements/connectivity", f"names nodes other than 0 to {len(elements.nodes) - 1}")
    if isinstance(elements, SpatialElements) and not np.isin(elements.held, np.arange(len(elements.nodes))).all():
        refuse(path, "elements/held", f"names nodes other than 0 to {len(elements.nodes) - 1}")
    _check_pieces(model, path)
    for name in ("triangles", "lines"):
        if surface is not None and not np.isin(getattr(surface, name), np.arange(len(surface.position))).all():
            refuse(path, f"surface/{name}", f"names points other than 0 to {len(surface.position) - 1}")
    if outline is not None and not np.isin(outline.edges, np.arange(len(outline.position))).all():
        refuse(path, "outline/edges", f"names points other than 0 to {len(outline.position) - 1}")
    if model.interior is not None:
        numbers_below(path, "interior/triangles", model.interior.triangles, len(model.interior.position), "points")
        numbers_below(path, "interior/modulus", model.interior.modulus, len(model.nominal), "parameters")
    if mesh is not None and not np.isin(mesh.connectivity, np.arange(len(mesh.nodes))).all():
        refuse(path, "mesh/connectivity", f"names nodes other than 0 to {len(mesh.nodes) - 1}")
    _check_beams(model, path)
    if stress is None:
        return
    for name, allowed in (("end", (0, 1)), ("fibre", (-1, 1))):
        if not np.isin(getattr(stress, name), allowed).all():
            refuse(path, f"stress/{name}", f"holds numbers other than {allowed[0]} and {allowed[1]}")
    if mesh is not None and not np.isin(stress.element, np.arange(len(mesh.connectivity))).all():
        refuse(path, "stress/element", f"names elements other than 0 to {len(mesh.connectivity) - 1}")


def _check_pieces(model: ReducedModel, path: Path) -> None:
    """Refuse pieces and loads on them whose numbers of rows, points or elements do not fit the body."""
    elements, points, components = model.elements, *model.invariants.stress_operator.shape[:2]
    if isinstance(elements, SpatialElements):
        if len(elements.stress_operator) != points * components:
            refuse(path, "elements/stress_operator", f"has {len(elements.stress_operator)} rows instead of {points * components}")
        if model.pieces is not None:
            numbers_below(path, "pieces/element", model.pieces.element, len(elements.connectivity), "elements")
        if model.stress is not None:
            numbers_below(path, "stress/element", model.stress.element, len(elements.connectivity), "elements")
    for name, load in (model.piece_loads or {}).items():
        if isinstance(elements, SpatialElements) and len(load.force) != len(elements.connectivity):
            refuse(path, f"piece_loads/{name}/force", f"has {len(load.force)} rows instead of {len(elements.connectivity)}")
    if model.face_errors and not ({"least", "largest"} < model.face_errors.keys()):
        refuse(path, "face_errors", 'lacks "least", "largest" or the errors by single forces')
    if model.pieces is not None and model.surface is not None and len(model.pieces.element) != len(model.surface.position):
        refuse(
            path, "pieces/element", f"tells {len(model.pieces.element)} points of {len(model.surface.position)} of the surface"
        )


def _check_beams(model: ReducedModel, path: Path) -> None:
    """Refuse sections that are not as many as the beams, or whose axis lies along their element."""
    sections, beams = model.sections, model.mesh or model.elements
    if sections is None or beams is None:
        return
    if beams.connectivity.dtype.kind not in "iu":
        refuse(
            path,
            f"{'mesh' if model.mesh else 'elements'}/connectivity",
            "holds numbers of nodes that are not stored as whole ones",
        )
    if len(sections.axis) != len(beams.connectivity):
        refuse(path, "sections/axis", f"has {len(sections.axis)} elements instead of {len(beams.connectivity)}")
    sides = np.zeros((len(sections.axis), 3))
    sides[:, : model.dimension] = beams.nodes[beams.connectivity[:, 1]] - beams.nodes[beams.connectivity[:, 0]]
    sizes = np.linalg.norm(sides, axis=1) * np.linalg.norm(sections.axis, axis=1)
    if np.any(np.linalg.norm(np.cross(sides, sections.axis), axis=1) <= PARALLEL_SINE * sizes):
        refuse(path, "sections/axis", "runs along an element, across which it should lie")


HIGHEST_POWER = 20

PARTS_WITH_ITEMS = ("interfaces", "shape", "surface", "surface_loads", "elements", "sections", "spin", "piece_loads")
"""Parts of which arrays can depend on parameters, besides the invariants."""


def check_derivatives(model: ReducedModel, path: Path, sizes: Sizes) -> None:
    """Refuse derivatives by parameters, or of entries, that do not exist."""
    for item, derivatives in model.all_derivatives.items():
        place = f"{dependence_group(item)}derivatives/{item}"
        fit_all(path, place, derivatives, sizes)
        numbers_below(path, f"{place}/parameter", derivatives.parameter, len(model.nominal), "parameters")
        numbers_below(path, f"{place}/entry", derivatives.entry, _size(model, path, place, item), "entries")


def check_affine(model: ReducedModel, path: Path, sizes: Sizes) -> None:
    """Refuse polynomials of the parameters that do not give the invariants at the nominal design."""
    p, sizes_of = np.array(list(model.nominal.values())), entry_sizes(model.invariants)
    for item, polynomial in model.all_polynomials.items():
        place = f"{dependence_group(item)}affine/{item}"
        names = [
            *SHAPES[type(model.invariants)],
            SPIN_STIFFENING,
            SURFACE_POSITION,
            *(f"elements.{name}" for kind in (Elements, SpatialElements) for name in SHAPES[kind]),
            *(f"sections.{name}" for name in SHAPES[BeamSections]),
        ]
        if item not in names:
            refuse(path, place, f"is the name of no invariant; there are {', '.join(names)}")
        fit_all(path, place, polynomial, sizes)
        numbers_below(path, f"{place}/factor", polynomial.factor + 1, len(p) + 1, "parameters")
        numbers_below(path, f"{place}/power", np.abs(polynomial.power), HIGHEST_POWER + 1, "powers")
        numbers_below(path, f"{place}/term", polynomial.term, len(polynomial.factor), "terms")
        numbers_below(path, f"{place}/entry", polynomial.entry, _size(model, path, place, item), "entries")
        part = item.split(".")[0]
        if part in PARTS_WITH_ITEMS and getattr(model, part) is None:
            continue
        nominal = model.item(item)
        here = places(nominal, polynomial.entry)
        difference = np.abs(polynomial.on(here)(p, len(here)) - nominal.ravel()[here])
        size = sizes_of[item] if item in sizes_of else largest(nominal)
        if not np.all(difference <= ROUND_OFF * size.at(here)):
            refuse(path, f"{place}/value", f"differs from invariants/{item} at the nominal design")


def _size(model: ReducedModel, path: Path, place: str, item: str) -> int:
    """Number of entries of an item; without bound if it is in a part that was not loaded."""
    if item.split(".")[0] in PARTS_WITH_ITEMS and getattr(model, item.split(".")[0]) is None:
        return np.iinfo(np.int64).max
    try:
        return model.item(item).size
    except (AttributeError, KeyError, IndexError, TypeError):
        refuse(path, place, "is the name of nothing in the file that could depend on parameters")
        raise


def check_attributes(model: ReducedModel, path: Path) -> None:
    """Refuse attributes that are not texts or numbers as they should be, and parameters without units."""
    if model.dimension not in (2, 3):
        refuse(path, "dimension", f"is {model.dimension} instead of 2 or 3")
    if model.units not in UNIT_SYSTEMS:
        refuse(path, "units", f"is {model.units!r} instead of one of {', '.join(UNIT_SYSTEMS)}")
    texts = {name: getattr(model, name) for name in ("reference_condition", "basis", "input_hash")}
    for group in ("nominal_units", "writers", "inputs", "source"):
        texts |= {f"{group}/{name}": value for name, value in getattr(model, group).items()}
    for name, value in texts.items():
        if not isinstance(value, str):
            refuse(path, name, f"is {value!r} instead of a text")
    if foreign := set(model.source) - set(model.inputs):
        refuse(path, f"source/{min(foreign)}", "is not among its inputs")
    for group in ("changes", "left_out", "stress_errors", "stress_error_at", "face_errors"):
        for name, value in getattr(model, group).items():
            if not isinstance(value, (int, float)):
                refuse(path, f"{group}/{name}", f"is {value!r} instead of a number")
    try:
        read_composition(model.composition, model.dimension)
    except ValueError as error:
        refuse(path, "composition", f"cannot be right: {error}")
    for name, value in model.nominal.items():
        if not isinstance(value, (int, float)) or not (value == 0 or SMALLEST <= abs(value) <= LARGEST):
            refuse(path, f"nominal/{name}", f"is {value!r} instead of a number that is zero or from {SMALLEST:g} to {LARGEST:g}")
        if name not in model.nominal_units:
            refuse(path, f"nominal_units/{name}", "is missing")


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
    check_attributes(model, path)
    sizes: Sizes = {
        "2": 2,
        "3": 3,
        "4": 4,
        "6": 6,
        "u": ELEMENT_COORDINATES,
        "w": 1 + ELEMENT_COORDINATES,
        "v": SPATIAL_ELEMENT_COORDINATES,
        "y": 1 + SPATIAL_ELEMENT_COORDINATES,
    }
    fit_all(path, "invariants", model.invariants, sizes)
    if "invariants" not in before:
        check_matrices(model.invariants, path)
    if model.sections is not None:
        fit_all(path, "sections", model.sections, sizes)
        check_sections(model, path)
    check_derivatives(model, path, sizes)
    check_affine(model, path, sizes)
    for name, point in (model.interfaces or {}).items():
        fit_all(path, f"interfaces/{name}", point, sizes)
        low, high = point.arc_length_range
        if not low <= point.arc_length <= high:
            refuse(path, f"interfaces/{name}/arc_length", f"is outside its range [{low:g}, {high:g}]")
    for group in ("surface_loads", "piece_loads"):
        for name, load in (getattr(model, group) or {}).items():
            fit_all(path, f"{group}/{name}", load, sizes)
    for part in ("stress", "shape", "mesh", "outline", "interior", "elements", "surface", "spin", "pieces", "left_out_shapes"):
        if getattr(model, part) is not None:
            fit_all(path, part, getattr(model, part), sizes)
    if model.spin is not None and "spin" not in before:
        check_spin(model.spin.stiffening, 1 if model.dimension == 2 else len(PAIRS), path)
    check_left_out(model, path)
    check_indices(model, path)
    if model.richer_invariants is not None and "richer_invariants" not in before:
        _check_richer(model, path)


def _check_richer(model: ReducedModel, path: Path) -> None:
    """Refuse a richer basis of the same body that is no valid model, or that lacks a part."""
    needed = ("richer_derivatives", "richer_affine", "richer_interfaces")
    if lacking := [name for name in needed if getattr(model, name) is None]:
        refuse(path, lacking[0], "is missing beside richer_invariants")
    if model.interfaces is not None and set(model.interfaces) != set(model.richer_interfaces or {}):
        refuse(path, "richer_interfaces", "has other interface points than interfaces")
    try:
        check(richer_model(model), path)
    except ModelFileError as error:
        refuse(path, "richer_invariants", f"or another group of the body in more shapes is wrong ({error})")
