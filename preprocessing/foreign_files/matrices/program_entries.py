"""Entries of the matrices that Abaqus and CalculiX write as text.

Abaqus (*MATRIX OUTPUT) writes lines `node, direction, node, direction, value` (FORMAT=MATRIX INPUT or LABELS), of one triangle or of
both, or lines `row column value` (FORMAT=COORDINATE), where the rows are the directions of the nodes in the order of their numbers.
CalculiX (*FREQUENCY, SOLVER=MATRIXSTORAGE) writes lines `row column value` of one triangle, and in another file, .dof, which direction
of which node a row is: `12.3` is direction 3 of node 12.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from preprocessing.foreign_files.matrices.number_lines import line_of, number_lines, plain_text, without_comments
from preprocessing.foreign_files.matrices.triangles import both_triangles

KEYWORD = re.compile(rb"(?m)^[ \t]*\*[^\n]*")
OF_MATRIX = re.compile(
    rb"[ \t]*\*[ \t]*MATRIX[ \t]+INPUT[ \t]*((?:,[ \t]*(?:NAME[ \t]*=[^,]*|TYPE[ \t]*=[ \t]*SYMMETRIC)[ \t]*)*)", re.I
)
"""The only keyword that may stand ahead of the lines: what Abaqus needs to read them again."""
DEGREE = re.compile(rb"[ \t]*(\d{1,15})\.(\d{1,2})[ \t]*")
LARGEST_LABEL = 10**15
"""Whole numbers that are exact as floating-point numbers, with room for directions."""


def of_program(text: bytes, n: int, d: int, degrees: bytes | None) -> dict[str, Any]:
    """Rows, columns and values of a symmetric matrix for n coordinates of nodes in space of dimension d.

    `labels` are the numbers of its nodes, rising, in whose order the rows are; they are None where the lines do not tell them.

    Parameters
    ----------
    degrees : content of the .dof file, if there is one

    Raises
    ------
    ValueError
        It names the line that is none of these, or the direction of a node that is missing.
    """
    body = without_comments(text, b"**")
    body = _behind_keyword(body)
    found = number_lines(body, (3, 5), "," if b"," in body else None)
    if not len(found):
        raise ValueError("it holds no line of numbers")
    labels: np.ndarray | None
    if found.shape[1] == 5:
        if degrees is not None:
            raise ValueError("its lines name nodes themselves, and need no .dof file; leave matrices.dof out")
        labels, row, column = _labelled(found, body, d)
    else:
        labels, row, column = _numbered(found, body, n, d, degrees)
    size = d * len(labels) if labels is not None else n
    _refuse_twice(row, column, size, body)
    row, column, value = both_triangles(row, column, found[:, -1], size, one_only=False)
    return {"shape": [size, size], "row": row, "column": column, "value": value, "labels": labels}


def _behind_keyword(body: bytes) -> bytes:
    """The text with *MATRIX INPUT left empty, which may stand ahead of all numbers."""
    found = next(KEYWORD.finditer(body), None)
    if found is None:
        return body
    if OF_MATRIX.fullmatch(found[0]) and not body[: found.start()].strip():
        body = body[: found.start()] + body[found.end() :]
        found = next(KEYWORD.finditer(body), None)
    if found is not None:
        number = body.count(b"\n", 0, found.start()) + 1
        raise ValueError(
            f"line {number} is a keyword; lines of one matrix are read, behind *MATRIX INPUT with NAME and "
            "TYPE=SYMMETRIC or behind no keyword"
        )
    return body


def _labelled(found: np.ndarray, body: bytes, d: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers of the nodes, and rows and columns in their order."""
    whole = found[:, :4] == np.floor(found[:, :4])
    right = whole & (found[:, :4] <= LARGEST_LABEL)
    _refuse_line(
        ~right, body, "has no whole numbers for nodes and directions: lines of Abaqus are node, direction, node, direction, value"
    )
    _refuse_line(
        found[:, [0, 2]] < 1,
        body,
        "has a node below 1: Abaqus numbers so what it adds itself, for example for connectors, beams and hybrid elements, of which no "
        "body here is made",
    )
    _refuse_line(
        (found[:, [1, 3]] < 1) | (found[:, [1, 3]] > d),
        body,
        f"has a direction beyond 1 to {d}: it is a rotation, a pressure or a temperature, or the body is not in "
        f"{'the plane' if d == 2 else 'space'}, and displacement-based solids have none",
    )
    places = found[:, :4].astype(np.int64)
    row, column = d * places[:, 0] + places[:, 1] - 1, d * places[:, 2] + places[:, 3] - 1
    degrees = np.unique(np.concatenate([np.unique(row), np.unique(column)]))
    return _labels(degrees, d, "no line names"), np.searchsorted(degrees, row), np.searchsorted(degrees, column)


def _numbered(
    found: np.ndarray, body: bytes, n: int, d: int, degrees: bytes | None
) -> tuple[np.ndarray | None, np.ndarray, np.ndarray]:
    """Node numbers, and rows and columns in their order, where rows are numbers; a .dof file explains them if there is one."""
    meant = None if degrees is None else _degrees(degrees, d)
    rows = n if meant is None else len(meant)
    right = (found[:, :2] == np.floor(found[:, :2])) & (found[:, :2] >= 1) & (found[:, :2] <= rows)
    of_what = f"directions of {n // d} nodes" if meant is None else "lines of its .dof file"
    _refuse_line(~right, body, f"has no row and column from 1 to {rows}, the number of the {of_what}")
    row, column = found[:, :2].T.astype(np.int64) - 1
    lacking = np.setdiff1d(np.arange(rows), np.concatenate([row, column]))
    if len(lacking):
        raise ValueError(f"no line has row {lacking[0] + 1}, one of {len(lacking)} that are missing of {rows}")
    if meant is None:
        return None, row, column
    order = np.argsort(meant)
    place = np.empty(rows, np.int64)
    place[order] = np.arange(rows)
    return _labels(meant[order], d, "the .dof file lacks"), place[row], place[column]


def _degrees(content: bytes, d: int) -> np.ndarray:
    """Number of every line of a .dof file: d times the node, plus the direction from 0."""
    found = []
    for number, line in enumerate(plain_text(content).split(b"\n"), 1):
        if not line.strip():
            continue
        degree = DEGREE.fullmatch(line)
        if degree is None:
            raise ValueError(f"line {number} of its .dof file is not a node, a point and a direction")
        if not 1 <= int(degree[2]) <= d:
            raise ValueError(
                f"line {number} of its .dof file has direction {int(degree[2])}, and displacement-based solids here have 1 to {d}"
            )
        found.append(d * int(degree[1]) + int(degree[2]) - 1)
    if len(set(found)) < len(found):
        raise ValueError("its .dof file has a direction of a node twice")
    return np.array(found, np.int64)


def _labels(degrees: np.ndarray, d: int, who: str) -> np.ndarray:
    """Numbers of the nodes, each of which has all directions among these, rising."""
    labels = np.unique(degrees // d)
    lacking = np.setdiff1d(np.add.outer(d * labels, np.arange(d)).ravel(), degrees)
    if len(lacking):
        raise ValueError(
            f"{who} direction {lacking[0] % d + 1} of node {lacking[0] // d}, one of {len(lacking)} that are missing. Export the body "
            "without supports, rigid bodies and equations, which take directions out"
        )
    return labels


def _refuse_line(wrong: np.ndarray, body: bytes, what: str) -> None:
    """Refuse the first line with something wrong (n, fields)."""
    lines = np.flatnonzero(wrong.any(axis=1))
    if len(lines):
        raise ValueError(f"line {line_of(body, int(lines[0]))} {what}")


def _refuse_twice(row: np.ndarray, column: np.ndarray, n: int, body: bytes) -> None:
    """Refuse a place that two lines give: these programs write each once, and it is not clear whether both would add up."""
    _, first = np.unique(row * n + column, return_index=True)
    if len(first) < len(row):
        again = np.setdiff1d(np.arange(len(row)), first)[0]
        raise ValueError(f"line {line_of(body, int(again))} gives a place that another line gave before")
