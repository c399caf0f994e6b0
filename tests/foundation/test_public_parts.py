"""Formulas compiled by what numba documents alone give the same numbers as those compiled by its private parts."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PRIVATE = {"numba_parts.py", "written_code.py"}
"""Files of `toolkit/foundation/compiled` that may import private parts of numba, and llvmlite."""

FORMULAS = """
import json, sys
from typing import NamedTuple
import numba
import numpy as np
if sys.argv[1:] == ["newer"]:
    numba.version_info = numba.version_info._replace(short=(99, 0))
if sys.argv[1:] == ["changed"]:
    sys.modules["numba.core.untyped_passes"] = sys.modules["numba.core.codegen"] = None
from toolkit.foundation.compiled.calls import call
from toolkit.foundation.compiled.public_parts import PUBLIC_ONLY
from toolkit.foundation.kernel import inlined, inner, kernel, plain, slots
from toolkit.foundation.compiled.rows import add_rows, add_to_each, subtract_multiples
from toolkit.components.joints.kernels.laws import SIGNATURE, angle_law

class Deep(NamedTuple):
    rows: np.ndarray
    nothing: None
    scale: float

class Record(NamedTuple):
    deep: Deep
    entries: np.ndarray
    numbers: np.ndarray

@inner
def third(x):
    return x / 3

@inlined
def ninth(x):
    return third(third(x))

@kernel
def by_all(functions, record, h, law, out, values):
    functions[1](h, h, law[0], law[1], law[2:4], law[4])
    out[0] += ninth(record.deep.scale) * law[0, 0]
    add_rows(out, 0.3, -2.0, record.entries, record.numbers, 1, 5, record.deep.rows)
    add_to_each((out, values[8:16]), record.deep.rows, 3, record.entries, 0, 1)
    subtract_multiples(values, (0, 8), (0.1, 0.2, 0.3, 0.4), (16, 24), 7)

def answered(function, functions):
    rng = np.random.default_rng(1)
    record = Record(Deep(rng.normal(size=(6, 8)), None, 5.0), rng.normal(size=16), rng.integers(0, 6, 16))
    out, values, law = rng.normal(size=8), rng.normal(size=32), np.zeros((5, 2))
    call(function, functions, record, np.array([0.3, 0.7]), law, out, values)
    return [*out.tolist(), *values.tolist(), *law.ravel().tolist()]

@kernel
def doubled(x):
    return 2 * x

if sys.argv[1:]:
    print(json.dumps([PUBLIC_ONLY, [doubled(2.0)], [4.0]]))
else:
    found = answered(by_all, slots([angle_law, angle_law], SIGNATURE))
    print(json.dumps([PUBLIC_ONLY, found, answered(plain(by_all), (plain(angle_law),) * 2)]))
"""


@pytest.fixture
def answers(tmp_path: Path) -> Callable[..., tuple[bool, list[float], list[float]]]:
    """Whether a process uses documented parts alone, and its numbers, compiled and as plain Python."""
    (tmp_path / "formulas.py").write_text(FORMULAS)

    def ask(numba: str, *changes: str) -> tuple[bool, list[float], list[float]]:
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "FFRF_NUMBA": numba, "NUMBA_CACHE_DIR": str(tmp_path)}
        command = [sys.executable, tmp_path / "formulas.py", *changes]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        public, found, plain = json.loads(done.stdout)
        return public, found, plain

    return ask


def private_imports(file: Path) -> list[str]:
    """Modules of numba and llvmlite that a file imports, without those that are documented."""
    text, found = file.read_text(), []
    for each in ast.walk(ast.parse(text if "numba." in text or "llvmlite" in text else "")):
        if isinstance(each, ast.ImportFrom):
            found.append(each.module or "")
        elif isinstance(each, ast.Import):
            found += [name.name for name in each.names]
    return [name for name in found if name.startswith(("numba.", "llvmlite.")) and name != "numba.extending"]


def test_private_parts_of_numba_are_imported_in_two_files_alone():
    files = [file for room in ("toolkit", "preprocessing") for file in (ROOT / room).rglob("*.py")]
    found = {file for file in files if private_imports(file)}
    assert found == {ROOT / "toolkit" / "foundation" / "compiled" / name for name in PRIVATE}


def test_numbers_are_the_same_to_the_last_bit_and_those_of_plain_python(answers):
    (public, found, plain), (private, expected, _) = answers("public"), answers("")
    assert (public, private) == (True, False)
    assert found == expected
    assert found == pytest.approx(plain, rel=1e-14, abs=1e-14)


@pytest.mark.parametrize("change", ["newer", "changed"])
def test_a_numba_that_is_newer_or_lacks_a_private_part_is_used_by_its_documented_parts(answers, change):
    public, found, plain = answers("", change)
    assert public
    assert found == pytest.approx(plain, rel=1e-14, abs=1e-14)
