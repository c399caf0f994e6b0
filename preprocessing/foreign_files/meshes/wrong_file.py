"""Errors of mesh files that cannot be read as they are, and the numbers that they give nodes and elements."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolkit.foundation.errors import InputError


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
