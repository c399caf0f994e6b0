"""Spoilt airfoil and skin files: a section, a skin, or one of the program's own errors; numpy's warnings count as failures."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from preprocessing import build
from preprocessing.airfoil.airfoil_file import read_airfoil
from preprocessing.builders.skin_recipe import SkinRecipe
from tests.fuzz.toml_mutations import document, spoilt
from toolkit.foundation.errors import ToolkitError
from toolkit.reduced_model.file import save

pytestmark = pytest.mark.robustness

ROOT = Path(__file__).parents[2]
AIRFOILS = sorted((ROOT / "tests" / "data" / "airfoils").glob("*.[dta]*"))
WING = ROOT / "models" / "morphing_wing"
SKIN = tomllib.loads((WING / "skin.toml").read_text())
FIELDS = ["nan", "inf", "*****", "1e999", "-1e308", "1e308", "1e155", "1e-320", "-0.0", "999.", "999. 999.", "0", "1", "2", "61. 61.",
          "1,5", "0x1", "1d0",
          "", " ", "\t", ";", ",", "#", "!", "text", "١", "²", "\ufeff", "\x00", "\x0c", "\x85", "1" * 400, "9" * 5000, "1 Sym Flag",
          "17 Num Pnts Upper\n17 Num Pnts Lower", "9" * 5000 + " Num Pnts\n1 Num Pnts", "1 2 3 4 5", "0.5 0.1\n" * 30]  # fmt: skip

fields = st.one_of(st.sampled_from(FIELDS), st.floats().map(str), st.floats(-1, 2).map(str), st.text(max_size=8))


def examples(count: int) -> settings:
    """The same cases in every run."""
    return settings(max_examples=count, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck))


@st.composite
def spoilt_rows(draw: Callable) -> str:
    """An airfoil file with one to four mistakes: fields and lines replaced, removed, doubled, exchanged, columns scaled."""
    lines = AIRFOILS[draw(st.integers(0, len(AIRFOILS) - 1))].read_text("latin-1").splitlines()
    for _ in range(draw(st.integers(1, 4))):
        i, j = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
        mistake = draw(
            st.sampled_from(["field", "field", "line", "delete", "insert", "exchange", "reverse", "cut", "scale", "double"])
        )
        if mistake == "field":
            split = lines[i].split()
            if split:
                split[draw(st.integers(0, len(split) - 1))] = draw(fields)
            lines[i] = " ".join(split)
        elif mistake == "line":
            lines[i] = draw(fields)
        elif mistake == "delete":
            del lines[min(i, j) : min(max(i, j), len(lines) - 1)]
        elif mistake == "insert":
            lines.insert(i, draw(fields))
        elif mistake == "exchange":
            lines[i], lines[j] = lines[j], lines[i]
        elif mistake == "reverse":
            lines[min(i, j) : max(i, j)] = lines[min(i, j) : max(i, j)][::-1]
        elif mistake == "cut":
            lines[-1] = lines[-1][: draw(st.integers(0, 8))]
        elif mistake == "scale":
            factor = draw(st.sampled_from([-1.0, 0.0, 100.0, 1e-3, 1e-9, 1e-200, 1e160, 1e308]))
            lines = [_scaled(line, factor) for line in lines]
        else:
            lines += lines
    return draw(st.sampled_from(["\n", "\r\n", "\r"])).join(lines)


def _scaled(line: str, factor: float) -> str:
    try:
        x, y = map(float, line.split())
    except ValueError:
        return line
    return f"{x} {y * factor}" if abs(factor) <= 1 else f"{x * factor} {y * factor}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with the files of a skin."""
    path = tmp_path_factory.mktemp("skin")
    for name in ("high_speed.dat", "low_speed.dat"):
        shutil.copy(WING / name, path)
    return path


def check(error: ToolkitError) -> None:
    """It is something to read, not the content of the file."""
    assert 10 < len(str(error)) < 40_000
    str(error).encode()


@examples(600)
@given(content=st.one_of(spoilt_rows(), spoilt_rows(), spoilt_rows(), st.text(max_size=200), st.lists(fields).map("\n".join)))
def test_a_spoilt_airfoil_is_refused_by_the_program_itself_or_a_section(folder, content):
    path = folder / "section.dat"
    path.write_text(content, encoding="utf-8", errors="replace", newline="")
    try:
        airfoil = read_airfoil(path)
        airfoil.leading_edge, airfoil.thickness  # noqa: B018
    except ToolkitError as error:
        check(error)
    else:
        assert np.isfinite(airfoil.points).all()
        assert np.isfinite(airfoil.thickness).all()


@examples(200)
@given(content=st.binary(max_size=100))
def test_any_bytes_are_no_airfoil(folder, content):
    path = folder / "bytes.dat"
    path.write_bytes(content)
    with pytest.raises(ToolkitError) as error:
        read_airfoil(path)
    check(error.value)


@examples(300)
@given(table=spoilt([SKIN]))
def test_a_spoilt_skin_file_is_refused_by_the_program_itself_or_used(folder, table):
    path = folder / "skin.toml"
    path.write_text(document(table), encoding="utf-8")
    try:
        SkinRecipe.read(path).hash()
        save(build(path), folder / "skin.h5")
    except ToolkitError as error:
        check(error)
