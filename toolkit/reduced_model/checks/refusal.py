"""How a reduced model is refused: by the file, the place in it and what is wrong there."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolkit.foundation.errors import ModelFileError


def refuse(path: Path, place: str, problem: str) -> None:
    """Refuse a model for what is wrong at one place in its file."""
    raise ModelFileError(f"{str(path)!r}: {place} {problem}. Build it again with ffrf-preprocess.")


def numbers_below(path: Path, place: str, numbers: np.ndarray, end: int, what: str) -> None:
    """Refuse numbers that cannot count from 0 up to, but without, `end`."""
    if numbers.dtype.kind not in "iu" or numbers.min(initial=0) < 0 or numbers.max(initial=-1) >= end:
        refuse(path, place, f"holds numbers of {what} that do not exist")
