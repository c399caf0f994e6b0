"""Entries of a sparse matrix, whatever the format of its file: SciPy's archives, Matrix Market, Abaqus, CalculiX.

Entries of the matrices that Abaqus and CalculiX write as text.

Abaqus (*MATRIX OUTPUT) writes lines `node, direction, node, direction, value` (FORMAT=MATRIX INPUT or LABELS), of one triangle or of
both, or lines `row column value` (FORMAT=COORDINATE), where the rows are the directions of the nodes in the order of their numbers.
CalculiX (*FREQUENCY, SOLVER=MATRIXSTORAGE) writes lines `row column value` of one triangle, and in another file, .dof, which direction
of which node a row is: `12.3` is direction 3 of node 12.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from preprocessing.foreign_files.contents import MatrixEntries
from preprocessing.foreign_files.number_files import archive, both_triangles, line_of, number_lines, plain_text, without_comments

Entries = tuple[Sequence[int], np.ndarray, np.ndarray, np.ndarray]
"""Shape, rows, columns and values; equal places add up."""


def of_archive(arrays: dict[str, np.ndarray]) -> Entries:
    """Entries of a matrix that `scipy.sparse.save_npz` wrote; raises ValueError if its parts do not fit together."""
    kind = arrays["format"].item()
    kind = kind.decode("ascii") if isinstance(kind, bytes) else kind
    shape = [int(size) for size in arrays["shape"].tolist()]
    if len(shape) != 2 or min(shape) < 0:
        raise ValueError(f"its shape is {shape} instead of rows and columns")
    if kind == "coo":
        return shape, _whole(arrays, "row"), _whole(arrays, "col"), arrays["data"]
    if kind == "dia":
        return shape, *_of_diagonals(_whole(arrays, "offsets"), arrays["data"], shape)
    if kind == "csc":
        column, row, value = _of_blocks(arrays, shape[::-1], arrays["data"][..., None, None])
    elif kind in ("csr", "bsr"):
        row, column, value = _of_blocks(arrays, shape, arrays["data"] if kind == "bsr" else arrays["data"][..., None, None])
    else:
        raise ValueError("its format is none of csr, csc, bsr, coo and dia")
    return shape, row, column, value


def _of_blocks(arrays: dict[str, np.ndarray], shape: list[int], blocks: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Row, column and value of compressed rows of blocks (n, height, width)."""
    indices, starts = _whole(arrays, "indices"), _whole(arrays, "indptr")
    if blocks.ndim != 3 or 0 in blocks.shape[1:] or shape[0] % blocks.shape[1] or shape[1] % blocks.shape[2]:
        raise ValueError(f"its blocks of shape {blocks.shape[1:]} do not divide its shape {shape}")
    n, count = shape[0] // blocks.shape[1], np.diff(starts)
    if len(starts) != n + 1 or starts[0] != 0 or np.any(count < 0) or np.any(starts > min(len(indices), len(blocks))):
        raise ValueError(f"its indptr does not rise from 0 to at most {min(len(indices), len(blocks))} in {n} steps")
    used = int(starts[-1])
    if np.any(indices[:used] < 0) or np.any(indices[:used] >= shape[1] // blocks.shape[2]):  # before products that could overflow
        raise ValueError(f"it has entries outside of its shape {shape}")
    down, across = np.indices(blocks.shape[1:])
    row = np.repeat(np.arange(n), count)[:, None, None] * blocks.shape[1] + down
    column = indices[:used, None, None] * blocks.shape[2] + across
    return row.ravel(), column.ravel(), blocks[:used].ravel()


def _whole(arrays: dict[str, np.ndarray], name: str) -> np.ndarray:
    """Whole numbers of one line."""
    found = arrays[name]
    if found.dtype.kind not in "iu" or found.ndim != 1:
        raise ValueError(f"its {name} are no line of whole numbers")
    return found.astype(np.int64)


def _of_diagonals(offsets: np.ndarray, data: np.ndarray, shape: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Entries of a matrix stored by diagonals: entry j of diagonal k stands in column j and row j - k."""
    if data.ndim != 2 or len(data) != len(offsets) or np.any(np.abs(offsets) > max(shape)):
        raise ValueError("its diagonals do not fit to their offsets")
    column = np.broadcast_to(np.arange(data.shape[1]), data.shape)
    row = column - offsets[:, None]
    inside = (column < shape[1]) & (row >= 0) & (row < shape[0])
    return row[inside], column[inside], data[inside]


MATRIX_MARKET = b"%%MatrixMarket"
SHORTEST_ENTRY = 2
"""Bytes of a line: a digit and its end."""
HEAD = re.compile(rb"%%MatrixMarket[ \t]+matrix[ \t]+(\w+)[ \t]+([\w-]+)[ \t]+([\w-]+)[ \t]*\n", re.IGNORECASE)
SIZE = re.compile(rb"(?:[ \t]*\n|%[^\n]*\n)*[ \t]*(\d{1,18})[ \t]+(\d{1,18})(?:[ \t]+(\d{1,18}))?[ \t]*\n")
READ = ({b"coordinate", b"array"}, {b"real", b"double", b"integer"}, {b"general", b"symmetric"})
"""The words of the first line whose matrices are those of elastic bodies."""
NOT_MEANT = (b"complex", b"pattern", b"hermitian", b"skew-symmetric")
"""The other words of the format."""


def of_matrix_market(text: bytes) -> Entries:
    """Entries of a matrix from a file's text; raises ValueError if it is not what its first lines claim."""
    head = HEAD.match(text)
    if head is None:
        raise ValueError("its first line is not: %%MatrixMarket matrix coordinate real symmetric, or the like")
    layout, kind, symmetry = words = [word.lower() for word in head.groups()]
    _refuse_words(words)
    size = SIZE.match(text, head.end())
    if size is None or (size[3] is None) != (layout == b"array"):
        raise ValueError("it does not say how many rows and columns, and if sparse how many entries, it has")
    rows, columns = int(size[1]), int(size[2])
    if symmetry == b"symmetric" and rows != columns:
        raise ValueError(f"it claims a symmetric matrix of {rows} rows and {columns} columns")
    claimed = _claimed(rows, columns, size[3], symmetry, len(text))
    body, before = without_comments(text[size.end() :], b"%"), text.count(b"\n", 0, size.end())
    found = number_lines(body, (3,) if layout == b"coordinate" else (1,), None, before)
    if len(found) != claimed:
        raise ValueError(f"it claims {claimed} entries, and holds {len(found)}")
    if kind == b"integer":
        _refuse_fractions(found[:, -1:], body, before)
    row, column = _places(found, (rows, columns), body, before) if layout == b"coordinate" else _dense(rows, columns, symmetry)
    if symmetry == b"general":
        return (rows, columns), row, column, found[:, -1]
    return (rows, columns), *both_triangles(row, column, found[:, -1], rows, "it claims to be symmetric, and")


def _refuse_words(words: list[bytes]) -> None:
    """Refuse matrices that no elastic body has."""
    for word, known in zip(words, READ, strict=True):
        if word not in known:
            called = f"it is {word.decode()}" if word in NOT_MEANT else "its first line has a word that the format does not know"
            raise ValueError(f"{called}; real matrices are needed, coordinate or array, general or symmetric")


def _claimed(rows: int, columns: int, entries: bytes | None, symmetry: bytes, size: int) -> int:
    """Number of entries that the lines must hold."""
    dense = rows * columns if symmetry == b"general" else rows * (rows + 1) // 2
    claimed, least = (int(entries),) * 2 if entries else (dense, rows * columns // 2)
    if SHORTEST_ENTRY * least > size:
        raise ValueError(f"it claims {least} entries or more, and has {size} bytes")
    return claimed


def _dense(rows: int, columns: int, symmetry: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of dense entries, which stand column by column; of symmetric ones those from the diagonal down."""
    column, row = np.divmod(np.arange(rows * columns), max(rows, 1))
    below = row >= column if symmetry == b"symmetric" else slice(None)
    return row[below], column[below]


def _places(found: np.ndarray, shape: tuple[int, int], body: bytes, before: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns from 0 of sparse entries, which count from 1."""
    _refuse_fractions(found[:, :2], body, before)
    wrong = np.flatnonzero(np.any((found[:, :2] < 1) | (found[:, :2] > shape), axis=1))
    if len(wrong):
        raise ValueError(f"line {line_of(body, wrong[0], before)} is outside of its {shape[0]} rows and {shape[1]} columns")
    return tuple(found[:, :2].T.astype(np.int64) - 1)  # type: ignore[return-value]


def _refuse_fractions(numbers: np.ndarray, body: bytes, before: int) -> None:
    """Refuse what should be whole numbers and are none."""
    wrong = np.flatnonzero(np.any(numbers != np.floor(numbers), axis=1))
    if len(wrong):
        raise ValueError(f"line {line_of(body, wrong[0], before)} has a fraction where the format has a whole number")


KEYWORD = re.compile(rb"(?m)^[ \t]*\*[^\n]*")
OF_MATRIX = re.compile(
    rb"[ \t]*\*[ \t]*MATRIX[ \t]+INPUT[ \t]*((?:,[ \t]*(?:NAME[ \t]*=[^,]*|TYPE[ \t]*=[ \t]*SYMMETRIC)[ \t]*)*)", re.I
)
"""The only keyword that may stand ahead of the lines: what Abaqus needs to read them again."""
DEGREE = re.compile(rb"[ \t]*(\d{1,15})\.(\d{1,2})[ \t]*")
LARGEST_LABEL = 10**15
"""Whole numbers that are exact as floating-point numbers, with room for directions."""


def of_program(text: bytes, n: int, d: int, degrees: bytes | None) -> MatrixEntries:
    """Entries of a symmetric matrix for n coordinates of nodes in space of dimension d, with the numbers of the nodes.

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


def matrix_entries(path: str, n: str, dimension: str, degrees: str = "") -> MatrixEntries:
    """Entries of SciPy's .npz, Matrix Market, or the text of Abaqus or CalculiX for n coordinates of nodes.

    The text of the last two also tells the numbers of the nodes.
    """
    file = Path(path)
    text = b"" if file.suffix == ".npz" else plain_text(file.read_bytes())
    is_market = text.lstrip()[: len(MATRIX_MARKET)].lower() == MATRIX_MARKET.lower()
    if file.suffix != ".npz" and not is_market:
        return of_program(text, int(n), int(dimension), Path(degrees).read_bytes() if degrees else None)
    if degrees:
        raise ValueError("a .dof file says what the rows of CalculiX's text are, and this is none; leave matrices.dof out")
    shape, row, column, value = of_matrix_market(text) if is_market else of_archive(archive(file))
    return {"shape": [int(size) for size in shape], "row": row, "column": column, "value": value}
