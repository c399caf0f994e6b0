"""Numbers of a deck: every field is a whole number, or a number, or an error with its line."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from itertools import chain
from typing import Any

import numpy as np

from preprocessing.foreign_files.abaqus.blocks import Block, fields_of
from toolkit.foundation.errors import InputError

WHOLE = re.compile(r"[+-]?[0-9]+", re.ASCII)
NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[EeDd]([+-]?[0-9]+))?", re.ASCII)
UNIT = 1e-2
"""Difference of the square of a normal's length from one: decks write few digits of it."""
LARGEST_LABEL = 999_999_999
"""The largest number of a node or element that Abaqus allows."""


def whole(text: str, place: str) -> int:
    """Whole number from a text.

    Raises
    ------
    InputError
        The field is none.
    """
    if not WHOLE.fullmatch(text) or len(text) > 18:
        raise InputError(f"{place}: a field is no whole number. Fix it, or export the deck again.")
    return int(text)


def number(text: str, place: str) -> float:
    """Number from a text, also with Fortran's D instead of E; an empty field is zero.

    Raises
    ------
    InputError
        The field is none.
    """
    if not text:
        return 0.0
    found = NUMBER.fullmatch(text)
    if not found or not np.isfinite(value := float(f"{found[1]}e{found[2] or 0}")):
        raise InputError(f"{place}: a field is no number. Fix it, or export the deck again.")
    return value


def label(text: str, place: str) -> int:
    """Number of a node or element, from 1 on, from a text; raises as `whole`."""
    found = whole(text, place)
    if not 1 <= found <= LARGEST_LABEL:
        raise InputError(f"{place}: {found} is no number of a node or element; these go from 1 to {LARGEST_LABEL}.")
    return found


def node_rows(block: Block) -> tuple[np.ndarray, np.ndarray]:
    """Labels (n,) and coordinates (n, 3) of the data lines of *NODE; what is missing or empty is zero.

    Raises
    ------
    InputError
        A field is no number; says which line.
    """
    if (found := _node_table(block)) is not None:
        return found
    rows = [_node_row(place, fields) for place, fields in block.rows()]
    table = np.array(rows, float).reshape(-1, 4)
    return table[:, 0].astype(np.int64), table[:, 1:]


def _node_table(block: Block) -> tuple[np.ndarray, np.ndarray] | None:
    """Labels and coordinates at once, where every line has a label and two or three plain numbers; None elsewhere."""
    lines = block.data()
    first = next((line for line in lines if line.strip()), "")
    n = first.count(",")
    if n not in (2, 3):
        return None
    found = _table(chain([first], lines), np.dtype([("label", np.int64), ("place", np.float64, (n,))]))
    if found is None:
        return None
    labels, places = found["label"].copy(), np.zeros((len(found), 3))  # without the table, which else stays in memory
    places[:, :n] = found["place"]
    fine = np.all((labels >= 1) & (labels <= LARGEST_LABEL)) and np.all(np.isfinite(places))
    return (labels, places) if fine else None


def _table(lines: Iterator[str], kind: Any) -> np.ndarray | None:
    """Table of lines with as many numbers each, read at once; None where there are none, or one is no plain number."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # that there are no data, or that a whole number is none
            return np.loadtxt(lines, kind, delimiter=",", comments=None, ndmin=2 if np.dtype(kind).names is None else 1)
    except (ValueError, Warning):
        return None


def _node_row(place: str, fields: list[str]) -> list[float]:
    """Label and coordinates of a line, which may go on with a normal that beams and shells use."""
    if not fields:
        raise InputError(f"{place}: a node needs a number. Fix the line.")
    values = [number(text, place) for text in fields[1:]]
    normal = values[3:]
    unit = len(normal) == 3 and abs(sum(x * x for x in normal) - 1) < UNIT
    if normal and not ((unit or not any(normal)) and any("." in text for text in fields)):
        raise InputError(
            f"{place}: a node has a number, three coordinates and at most a unit normal, and here are {len(fields)} fields. If commas are "
            "meant as decimal points, write points."
        )
    return [label(fields[0], place), *[*values, 0.0, 0.0, 0.0][:3]]


def element_rows(block: Block, n_nodes: int) -> np.ndarray:
    """Label and nodes (n_e, 1 + n_nodes) of the data lines of *ELEMENT, each over as many lines as it needs.

    Raises
    ------
    InputError
        A field is no whole number, or an element has another number of nodes; says which line.
    """
    found = _element_table(block, 1 + n_nodes)
    return _element_rows(block, 1 + n_nodes) if found is None else found


def _element_table(block: Block, width: int) -> np.ndarray | None:
    """Rows of elements read at once, where lines hold only whole numbers and all elements have as many lines; else None."""
    lines = block.data()
    first = next((line for line in lines if line.strip()), "")
    lines = chain([first], lines)
    if len(fields_of(first)) < width:
        lines = _joined(lines, width)
    found = _table((line.rstrip().rstrip(",") for line in lines) if first.rstrip().endswith(",") else lines, np.int32)
    fine = found is not None and found.shape[1] == width and found.min() >= 1 and found.max() <= LARGEST_LABEL
    return found if fine else None


def _joined(lines: Iterator[str], width: int) -> Iterator[str]:
    """Lines of elements that take several of them, put together until they have so many fields."""
    whole, count = [], 0
    for line in lines:
        if text := line.strip().rstrip(","):
            whole.append(text)
            count += 1 + text.count(",")
            if count >= width:
                yield ",".join(whole)
                whole, count = [], 0
    if whole:
        yield ",".join(whole)


def _element_rows(block: Block, width: int) -> np.ndarray:
    """Rows of elements read line by line."""
    rows, row, began = list[list[int]](), list[int](), ""
    for place, line in block.lines():
        began = began if row else place
        row += [label(text, place) for text in fields_of(line)]
        if len(row) > width:
            raise InputError(
                f"{place}: an element of this type has {width - 1} nodes, and here are {len(row) - 1}. Fix the line."
            )
        if len(row) == width:
            rows.append(row)
            row = []
    if row:
        raise InputError(f"{began}: an element of this type has {width - 1} nodes, and here are {len(row) - 1}. Fix the line.")
    return np.array(rows, np.int32).reshape(-1, width)
