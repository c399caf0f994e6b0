"""What the reader of every mesh format returns as plain arrays, and the errors of files that cannot be read."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NotRequired, TypedDict

import numpy as np

from preprocessing.foreign_files.wire import Sent
from toolkit.foundation.errors import InputError

Elements = list[tuple[str, np.ndarray]]
"""Kind of element in the words of meshio, and the nodes (n_e, n_local) of the elements of that kind, as places among the points."""


class PointMass(NamedTuple):
    """Concentrated mass with its rotary inertia, such as MASS and ROTARYI of Abaqus or CONM2 of Nastran."""

    place: tuple[float, ...]  # of its centre of mass, as many coordinates as the points have
    mass: float
    carriers: np.ndarray  # places among the points of the nodes that it moves with: its own node, or those of a rigid body
    inertia: tuple[float, ...] = (0.0,) * 6  # tensor J about the centre of mass: J_xx, J_yy, J_zz, J_xy, J_xz, J_yz
    rigid: bool = True  # whether several carriers are rigid (RBE2, *RIGID BODY), or it follows their mean (RBE3, *DISTRIBUTING)
    source: str = ""  # "MASS, line 40"


class LeftOutContent(NamedTuple):
    """Entry of the file that is not part of the body."""

    what: str  # name of the keyword, card or element type
    number: int  # how many of it
    why: str  # in words


class MeshContents(NamedTuple):
    """Nodes, elements and groups of a mesh file; every one of its elements is in `cells`, in `masses` or in `left_out`."""

    points: np.ndarray  # (n, 2) or (n, 3), in the order of the file
    cells: Elements
    groups: list[tuple[str, Elements]]  # name, nodes ("vertex") or elements; of one that is here twice the first tells the nodes
    labels: np.ndarray = np.zeros(0, np.int64)  # (n,) number of every node in the file; none where the format counts them
    masses: Sequence[PointMass] = ()
    left_out: Sequence[LeftOutContent] = ()
    remarks: Sequence[str] = ()  # what the user should know of the reading, full sentences

    def sent(self) -> dict[str, Sent]:
        """Record of the contents as a reader's process sends it: lists, texts, numbers and arrays."""
        return {
            **self._asdict(),
            "masses": [each._asdict() for each in self.masses],
            "left_out": [each._asdict() for each in self.left_out],
        }

    @classmethod
    def received(cls, found: Sent) -> MeshContents:
        """Contents from the record that was sent.

        Raises
        ------
        TypeError
            It is none.
        """
        if not isinstance(found, Mapping):
            raise TypeError("a mesh is a record of its contents")
        record: dict[str, Any] = {"masses": (), "left_out": (), **found}
        masses = [PointMass(**each) for each in record["masses"]]
        return cls(**{**record, "masses": masses, "left_out": [LeftOutContent(**each) for each in record["left_out"]]})


class MatrixEntries(TypedDict):
    """Entries of a sparse matrix; equal places add up."""

    shape: list[int]
    row: np.ndarray
    column: np.ndarray
    value: np.ndarray
    labels: NotRequired[
        np.ndarray | None
    ]  # rising numbers of its nodes, in whose order the rows are; None: the lines do not tell them


PLANE = {"triangle": 3, "triangle6": 6, "quad": 4, "quad8": 8, "quad9": 9}
"""Kinds of elements that are used, and their numbers of nodes."""
SPATIAL = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20, "hexahedron27": 27, "wedge": 6, "wedge15": 15}
"""The same in space."""
LOWER = {"vertex": 1, "line": 2, "line3": 3}
"""Kinds that serve to name groups only; in space those of the plane too."""
SOLID = ("tetra", "hexahedron", "wedge", "pyramid")
"""Beginnings of the names of spatial kinds."""
KNOWN = {**LOWER, **PLANE, **SPATIAL}
"""All of which meshes may consist."""


def wrong_file(path: Path, what: str, remedy: str, line: int = 0) -> InputError:
    """Error of a mesh file: what is wrong, in which line if that is known, and what to do."""
    where = f"line {line}: " if line else ""
    return InputError(f"the mesh {str(path)!r} cannot be read ({where}{what}). {remedy}")


def refuse_leave_out(path: Path, leave_out: frozenset[str], why: str) -> None:
    """Refuse names in leave_out where the format has nothing that could be left out."""
    if leave_out:
        raise InputError(
            f"leave_out in [mesh] names {', '.join(sorted(leave_out))}, but {why}, so that nothing of {str(path)!r} can be left out. "
            "Take leave_out away."
        )


class Labels:
    """Numbers that a file gives its nodes or elements, by which others of its lines name them."""

    def __init__(self, path: Path, labels: np.ndarray, what: str, remedy: str) -> None:
        """Raise InputError if a label is there twice."""
        self.path, self.what, self.remedy = path, what, remedy
        self.order = np.argsort(labels, kind="stable")
        self.rising = labels[self.order]
        if np.any(self.rising[1:] == self.rising[:-1]):
            raise wrong_file(path, f"it gives one number to two {what}s", remedy)

    def places(self, wanted: np.ndarray) -> np.ndarray:
        """Places among the labels of those that are wanted; raises InputError if one is not there."""
        at = np.searchsorted(self.rising, wanted)
        last = len(self.rising) - 1
        if wanted.size and (last < 0 or np.any(self.rising[np.minimum(at, last)] != wanted)):
            raise wrong_file(self.path, f"an element or a group has a {self.what} that the file does not hold", self.remedy)
        return self.order[at]


NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
LARGEST_WHOLE = 2**53
"""Whole numbers below it are exact as doubles."""


def numbers_of_text(path: Path, text: bytes, line: int, remedy: str) -> np.ndarray:
    """All numbers of a text that begins in a line of a file.

    Raises
    ------
    InputError
        A word is no number.
    """
    if not text.strip():
        return np.zeros(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy warns of what it cannot read, and stops there
        try:
            return np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError):
            pass
    raise wrong_file(path, "a word is no number", remedy, line + _first_wrong(text) if line else 0)


def whole_numbers(path: Path, numbers: np.ndarray, remedy: str, line: int = 0) -> np.ndarray:
    """Numbers that have to be whole, as integers.

    Raises
    ------
    InputError
        One is not, or is too large to be exact.
    """
    if not np.all((numbers == np.floor(numbers)) & (np.abs(numbers) < LARGEST_WHOLE)):
        raise wrong_file(path, "it has other numbers than whole ones for counts, numbers or types", remedy, line)
    return numbers.astype(np.int64)


def _first_wrong(text: bytes) -> int:
    """Lines before the first one that does not consist of numbers."""
    for k, line in enumerate(text.split(b"\n")):
        if not all(NUMBER.fullmatch(word) for word in line.split()):
            return k
    return 0


def alike_rows(
    values: np.ndarray, at: int, columns: tuple[int, ...], width_of: Callable[[np.ndarray], int]
) -> Iterator[np.ndarray | None]:
    """Numbers from one place on as tables of rows, of which each says how many numbers it has.

    A table ends where one of the given columns changes; `width_of` tells the width of a row from its first numbers up to the last of
    these columns. None, and then nothing more, where a row is not whole.
    """
    first = max(columns) + 1
    while at < len(values):
        head = values[at : at + first]
        width = width_of(head) if len(head) == first else 0
        if not first <= width <= len(values) - at:
            yield None
            return
        n, most = 1, 4
        while most:
            ahead = values[at + n * width : at + (n + most) * width]
            rows = ahead[: len(ahead) // width * width].reshape(-1, width)
            alike = np.all(rows[:, columns] == head[list(columns)], axis=1)
            here = len(alike) if alike.all() else int(alike.argmin())
            n, most = n + here, 2 * most if here == most else 0
        yield values[at : at + n * width].reshape(n, width)
        at += n * width


def included_file(main: Path, including: Path, name: str) -> Path:
    """The file that is meant by a name: sought from the folder of the main file, as solvers do that start there, else beside the file that
    names it.

    Raises
    ------
    InputError
        There are two such files, one in each of these folders.
    """
    plain = name.strip().strip("\"'").strip()
    from_main, beside = main.parent / plain, including.parent / plain
    if not os.path.lexists(from_main):
        return beside
    if os.path.lexists(beside) and os.path.realpath(from_main) != os.path.realpath(beside):
        raise InputError(
            f"{str(including)!r} includes a file that there is twice: {str(from_main)!r} and {str(beside)!r}. Rename one of them."
        )
    return from_main
