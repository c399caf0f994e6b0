"""Which formulas become part of their callers is said beside each of them, and follows from nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from toolkit.foundation.kernel import inlined, inner, kernel


@inner
def doubled(x):
    """2 x."""
    return 2 * x


@inlined
def fourfold(x):
    """4 x."""
    return doubled(doubled(x))


@kernel
def eightfold(x):
    """8 x."""
    return 2 * fourfold(x)


def test_a_formula_is_compiled_alike_whoever_calls_it_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """numba would inline all that an inlined formula calls too: measured, that is half of the code of a scene's equations."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert eightfold(1.5) == 12
    assert [[made.fndesc.inline for made in each.overloads.values()] for each in (doubled, fourfold, eightfold)] == [
        [False],
        [True],
        [False],
    ]
