"""Refusal of reduced models that are incomplete or cannot be physical; whatever is wrong is named by its place in the file."""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path

import numpy as np

from toolkit.foundation.errors import ModelFileError
from toolkit.foundation.units import LARGEST, SMALLEST, UNIT_SYSTEMS
from toolkit.reduced_model.checks.matrices import (
    ROUND_OFF,
    check_left_out,
    check_matrices,
    check_sections,
    check_spin,
    entry_sizes,
    largest,
)
from toolkit.reduced_model.checks.refusal import numbers_below, refuse
from toolkit.reduced_model.checks.shapes import SHAPES, Sizes, fit_all
from toolkit.reduced_model.description.composition import read_composition
from toolkit.reduced_model.elements import LOCAL, SPATIAL_LOCAL, Elements, SpatialElements
from toolkit.reduced_model.model import ReducedModel, dependence_group
from toolkit.reduced_model.parts.sections import BeamSections
from toolkit.reduced_model.parts.spin import SPIN_STIFFENING
from toolkit.reduced_model.questions.frozen_basis import richer_model
from toolkit.reduced_model.spatial_model import PAIRS, SURFACE_POSITION
from toolkit.reduced_model.thin_arrays import places

PARALLEL = 1e-6
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
    if np.any(np.linalg.norm(np.cross(sides, sections.axis), axis=1) <= PARALLEL * sizes):
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
    sizes: Sizes = {"2": 2, "3": 3, "4": 4, "6": 6, "u": LOCAL, "w": 1 + LOCAL, "v": SPATIAL_LOCAL, "y": 1 + SPATIAL_LOCAL}
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
