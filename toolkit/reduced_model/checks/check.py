"""Refusal of reduced models that are incomplete or cannot be physical; whatever is wrong is named by its place in the file."""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path

from toolkit.foundation.errors import ModelFileError
from toolkit.reduced_model.checks.attributes import check_attributes
from toolkit.reduced_model.checks.dependences import check_affine, check_derivatives
from toolkit.reduced_model.checks.indices import check_indices
from toolkit.reduced_model.checks.matrices import check_left_out, check_matrices, check_sections, check_spin
from toolkit.reduced_model.checks.refusal import refuse
from toolkit.reduced_model.checks.shapes import Sizes, fit_all
from toolkit.reduced_model.elements import LOCAL, SPATIAL_LOCAL
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.questions.frozen_basis import richer_model
from toolkit.reduced_model.spatial_model import PAIRS


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
