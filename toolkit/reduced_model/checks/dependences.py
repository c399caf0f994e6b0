"""Refusal of derivatives and polynomials that name what does not exist, or give other numbers than the model has."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolkit.reduced_model.checks.matrices import ROUND_OFF, entry_sizes, largest
from toolkit.reduced_model.checks.refusal import numbers_below, refuse
from toolkit.reduced_model.checks.shapes import SHAPES, Sizes, fit_all
from toolkit.reduced_model.elements import Elements, SpatialElements
from toolkit.reduced_model.model import ReducedModel, dependence_group
from toolkit.reduced_model.parts.sections import BeamSections
from toolkit.reduced_model.parts.spin import SPIN_STIFFENING
from toolkit.reduced_model.spatial_model import SURFACE_POSITION
from toolkit.reduced_model.thin_arrays import places

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
