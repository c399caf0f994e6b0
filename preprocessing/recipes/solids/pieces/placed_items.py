"""Arrays of pieces put into those of the body, or of all pieces one after the other, with their dependence on the parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from toolkit.reduced_model.checks.shapes import letters_of
from toolkit.reduced_model.dependence import Derivatives, Polynomial

LEFT_OUT = -1
"""Number along an axis that stands for what is not kept."""


class Placement(NamedTuple):
    """Place (n,) of every entry of a piece's item in the target, or `LEFT_OUT`, and the number of entries there."""

    to: np.ndarray
    size: int


class Placed(NamedTuple):
    """Arrays, derivatives and polynomials of items, by name, as far as there are any."""

    arrays: dict[str, np.ndarray]
    derivatives: dict[str, Derivatives]
    affine: dict[str, Polynomial]


def placement(array: np.ndarray, letters: str, numbers: Mapping[str, np.ndarray], lengths: Mapping[str, int]) -> Placement:
    """Placement of an array whose axes have letters.

    `numbers` are those along axes that change, and `lengths` the lengths of these axes in the target.
    """
    along = [numbers.get(letter, np.arange(n)) for letter, n in zip(letters, array.shape, strict=True)]
    shape = tuple(lengths.get(letter, n) for letter, n in zip(letters, array.shape, strict=True))
    grids = np.meshgrid(*along, indexing="ij") if along else []
    if not grids:
        return Placement(np.zeros(1, int), 1)
    kept = np.all([grid >= 0 for grid in grids], axis=0)
    flat = np.ravel_multi_index(tuple(np.where(kept, grid, 0) for grid in grids), shape) if array.size else np.zeros(0, int)
    return Placement(np.where(kept.ravel(), flat.ravel(), LEFT_OUT), int(np.prod(shape)))


def in_row(number: int, size: int, count: int) -> Placement:
    """Placement of an item with so many entries, of the piece with a number, one piece after the other."""
    return Placement(number * size + np.arange(size), count * size)


def placed(pieces: Sequence[Mapping[str, Any]], places: Sequence[Mapping[str, Placement]]) -> Placed:
    """Sums of the pieces' items in their places.

    Parameters
    ----------
    pieces : fields of their reduced models
    places : of each piece, item -> placement
    """
    arrays, slopes, terms = dict[str, np.ndarray](), dict[str, list[Derivatives]](), dict[str, list[Polynomial]]()
    for piece, own in zip(pieces, places, strict=True):
        for item, place in own.items():
            values = np.ravel(_item(piece, item))
            here = place.to >= 0
            np.add.at(arrays.setdefault(item, np.zeros(place.size)), place.to[here], values[here])
            if item in piece["derivatives"]:
                slopes.setdefault(item, []).append(_moved(piece["derivatives"][item], place.to))
            if item in piece["affine"]:
                terms.setdefault(item, []).append(_moved(piece["affine"][item], place.to))
    return Placed(arrays, {k: sum(each[1:], each[0]) for k, each in slopes.items()}, {k: _sum(each) for k, each in terms.items()})


def letters_of_items(invariants: Any) -> dict[str, str]:
    """Letters of the axes of all invariants, see `toolkit.reduced_model.checks.shapes`."""
    letters = letters_of(invariants)
    return {f.name: letters[f.name] for f in fields(invariants)}


def _item(piece: Mapping[str, Any], item: str) -> np.ndarray:
    group, *rest = item.split(".")
    found: np.ndarray = getattr(piece[group][rest[0]], rest[1]) if rest else getattr(piece["invariants"], group)
    return found


def _moved(found: Any, to: np.ndarray) -> Any:
    """Derivatives or polynomial with entries in their new places, without those that are left out."""
    here = to[found.entry] >= 0
    along = {name: getattr(found, name)[here] for name in ("parameter", "term") if name in vars(found)}
    return replace(found, entry=to[found.entry[here]], value=found.value[here], **along)


def _sum(each: Sequence[Polynomial]) -> Polynomial:
    """Sum of polynomials, whose terms are given the same number of factors."""
    width = max(one.factor.shape[1] for one in each)
    starts = np.cumsum([0, *(len(one.factor) for one in each[:-1])])

    def padded(table: np.ndarray, blank: int) -> np.ndarray:
        return np.pad(table, ((0, 0), (0, width - table.shape[1])), constant_values=blank)

    return Polynomial(
        np.concatenate([padded(one.factor, -1) for one in each]),
        np.concatenate([padded(one.power, 0) for one in each]),
        np.concatenate([one.term + start for one, start in zip(each, starts, strict=True)]),
        np.concatenate([one.entry for one in each]),
        np.concatenate([one.value for one in each]),
    )
