"""Compiled formulas on disk: damaged ones are compiled again, and there is a place for them wherever the program is installed."""

from __future__ import annotations

import os
import runpy
import sys
import tempfile
import warnings
from pathlib import Path

import numba
import numpy as np
import pytest
from typer.testing import CliRunner

from toolkit.command_line import cli
from toolkit.command_line.announcements import at_work
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.compiled import compiled_code
from toolkit.foundation.compiled.compiled_code import CompiledCodeWarning
from toolkit.foundation.errors import InputError

PENDULUM = Path(__file__).parents[2] / "models" / "pendulum" / "scene.toml"
SOURCE = "from toolkit.foundation.kernel import kernel\n\n\n@kernel\ndef twice(x):\n    return 2 * x\n"


@pytest.fixture
def own(tmp_path, monkeypatch):
    """A file with a kernel, as users write them; remarks are made as in a process that has just begun."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setattr(compiled_code, "_TOLD", set())
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    compiled_code._shared.cache_clear()
    (tmp_path / "installed").mkdir()
    (tmp_path / "installed" / "own.py").write_text(SOURCE)
    yield tmp_path / "installed" / "own.py"
    compiled_code._shared.cache_clear()


def loaded(file: Path, argument: float = 2.0) -> int:
    """Call the kernel as a new process would; how often its code came from the disk."""
    kernel = runpy.run_path(str(file))["twice"]
    assert kernel(argument) == 2 * argument
    return sum(kernel.stats.cache_hits.values())


def kept(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.nbc"))


def read_only(folder: Path) -> None:
    """Nothing can be made in a folder of that name, not even by the administrator."""
    folder.write_text("a file")


def test_code_is_kept_beside_the_formula_one_file_for_each_type(own):
    assert (loaded(own), loaded(own)) == (0, 1)
    assert (loaded(own, 3), loaded(own, 3), loaded(own)) == (0, 1, 1)
    assert len(kept(own.parent / "__pycache__")) == 2
    own.write_text(SOURCE.replace("2 * x", "x + x"))
    assert loaded(own) == 0  # another formula


DAMAGE = {
    "empty": lambda content: b"",
    "random": lambda content: np.random.default_rng(1).bytes(len(content)),
    "half": lambda content: content[: len(content) // 2],
    "one bit": lambda content: content[:-100] + bytes([content[-100] ^ 1]) + content[-99:],
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_damaged_code_is_compiled_again_mended_and_told_once(own, kind):
    loaded(own)
    (file,) = kept(own.parent)
    whole = file.read_bytes()
    file.write_bytes(DAMAGE[kind](whole))
    with pytest.warns(CompiledCodeWarning, match="damaged; they are compiled again, once") as said:
        assert loaded(own) == 0
    assert len(said) == 1
    assert loaded(own) == 1
    assert kept(own.parent) == [file]


def test_an_installation_that_is_read_only_keeps_code_below_the_home(own, tmp_path):
    read_only(own.parent / "__pycache__")
    assert (loaded(own), loaded(own)) == (0, 1)
    assert len(kept(tmp_path / "home")) == 1
    assert (tmp_path / "home" / "ffrf-toolkit").stat().st_mode & 0o777 == 0o700


def test_without_a_home_code_is_kept_in_a_temporary_folder_and_it_is_said_once(own, tmp_path):
    read_only(own.parent / "__pycache__")
    read_only(tmp_path / "home")
    with pytest.warns(
        CompiledCodeWarning, match=r"cannot be kept in '.*__pycache__' \(.*\) or '.*home.*' \(.*\); they are in "
    ) as said:
        assert (loaded(own), loaded(own), loaded(own, 3)) == (0, 1, 0)
    assert len(said) == 1
    assert "Set NUMBA_CACHE_DIR to a folder that lasts" in str(said[0].message)
    (folder,) = (tmp_path / "temporary").iterdir()
    assert folder.name == f"ffrf-toolkit-{os.geteuid()}"
    assert folder.stat().st_mode & 0o777 == 0o700


def test_where_nothing_can_be_written_every_run_compiles_and_says_so(own, tmp_path):
    for folder in (own.parent / "__pycache__", tmp_path / "home", tmp_path / "temporary" / f"ffrf-toolkit-{os.geteuid()}"):
        read_only(folder)
    with pytest.warns(CompiledCodeWarning, match="every run compiles them again. Set NUMBA_CACHE_DIR"):
        assert (loaded(own), loaded(own)) == (0, 0)


def test_code_is_not_taken_from_a_folder_that_others_can_write_to(own, tmp_path):
    read_only(own.parent / "__pycache__")
    loaded(own)
    (tmp_path / "home" / "ffrf-toolkit").chmod(0o777)
    with pytest.warns(CompiledCodeWarning, match="other users can write there"):
        assert loaded(own) == 0


def test_the_folder_is_that_of_the_environment_not_that_of_a_file_in_the_current_folder(own, tmp_path, monkeypatch):
    """numba reads `.numba_config.yaml` in the current folder, and what is in such a folder is executed."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "hostile"))
    loaded(own)
    assert not (tmp_path / "hostile").exists()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "mine"))
    assert (loaded(own), loaded(own)) == (0, 1)
    assert len(kept(tmp_path / "mine")) == 1


def test_a_formula_without_a_file_is_kept_below_the_home(own, tmp_path):
    for hits in (0, 1):
        space = {"__name__": "typed"}
        exec(SOURCE, space)
        kernel = space["twice"]
        assert kernel(2.0) == 4.0
        assert sum(kernel.stats.cache_hits.values()) == hits
    assert len(kept(tmp_path / "home")) == 1


FORMULAS = """
'''A module.'''
from typing import NamedTuple
import numpy as np
from toolkit.foundation.kernel import inner, kernel

FACTOR = 2.0

class Pair(NamedTuple):
    a: float
    b: float

@inner
def factor(x):
    return FACTOR * x

@inner
def unused(x):
    return 7.0 * x

@inner
def raised(x, by=0.0):
    return x + by

@kernel
def twice(x):
    '''Twice x.'''
    return raised(factor(x)) + np.sin(0.0)

@kernel
def difference(pair):
    return pair.a - pair.b
"""


@pytest.mark.parametrize(
    ("old", "new", "hits", "value"),
    [
        ("'''Twice x.'''", "'''Two x,\n    and no more.'''  # so", 1, 4.0),
        ("'''A module.'''", "'''A module,\n\nand more.'''\n", 1, 4.0),
        ("7.0 * x", "8.0 * x", 1, 4.0),
        ("by=0.0", "by=1.0", 0, 5.0),
        ("FACTOR = 2.0", "FACTOR = 3.0", 0, 6.0),
        ("FACTOR * x", "FACTOR * x * x", 0, 8.0),
        ("FACTOR * x", "FACTOR * x + 1.0", 0, 5.0),
        ("np.sin(0.0)", "np.cos(0.0)", 0, 5.0),
        ("@inner\ndef factor", "@kernel\ndef factor", 0, 4.0),
    ],
)
def test_code_is_that_of_the_formula_and_of_all_that_it_calls_and_survives_all_other_edits(own, old, new, hits, value):
    own.write_text(FORMULAS)
    loaded(own)
    assert old in FORMULAS
    own.write_text(FORMULAS.replace(old, new))
    kernel = runpy.run_path(str(own))["twice"]
    assert kernel(2.0) == value
    assert sum(kernel.stats.cache_hits.values()) == hits


def test_formulas_without_an_entrance_are_kept_for_whoever_calls_them(own):
    own.write_text(FORMULAS)
    loaded(own)
    own.write_text(FORMULAS.replace("np.sin(0.0)", "np.cos(0.0)"))
    space = runpy.run_path(str(own))
    assert space["twice"](2.0) == 5.0
    assert [sum(space[name].stats.cache_hits.values()) for name in ("twice", "raised", "factor")] == [0, 1, 1]


def test_a_formula_without_an_entrance_refuses_python_in_words(own):
    own.write_text(FORMULAS)
    space = runpy.run_path(str(own))
    for _ in range(2):
        with pytest.raises(TypeError, match="factor is a formula that only other kernels call"):
            space["factor"](2.0)
        assert space["twice"](2.0) == 4.0  # which compiles it


MADE = """
from toolkit.foundation.kernel import kernel

def times(factor):
    @kernel
    def made(x):
        return factor * x
    return made

half, twice = times(0.5), times(2.0)
"""


def test_formulas_that_a_function_makes_are_told_apart(own):
    own.write_text(MADE)
    for hits in (0, 1):
        space = runpy.run_path(str(own))
        assert (space["half"](2.0), space["twice"](2.0)) == (1.0, 4.0)
        assert sum(space["twice"].stats.cache_hits.values()) == hits


def test_a_formula_that_moves_to_another_file_is_compiled_anew_with_all_that_call_it(own, monkeypatch):
    monkeypatch.syspath_prepend(own.parent)
    inner = "from toolkit.foundation.kernel import kernel\n\n\n@kernel\ndef again(x):\n    return x\n"
    for module in ("first_place", "second_place"):
        (own.parent / f"{module}.py").write_text(inner)
        own.write_text(SOURCE.replace("2 * x", "x + again(x)").replace("\n\n\n", f"\nfrom {module} import again\n\n\n", 1))
        assert (loaded(own), loaded(own)) == (0, 1)
        (own.parent / f"{module}.py").unlink()
        monkeypatch.delitem(sys.modules, module)


def test_fields_that_change_places_change_the_code(own):
    own.write_text(FORMULAS)
    space = runpy.run_path(str(own))
    assert space["difference"](space["Pair"](a=3.0, b=1.0)) == 2.0
    own.write_text(FORMULAS.replace("    a: float\n    b: float", "    b: float\n    a: float"))
    space = runpy.run_path(str(own))
    assert space["difference"](space["Pair"](a=3.0, b=1.0)) == 2.0


def test_a_formula_that_uses_a_number_of_another_module_is_compiled_by_every_process(own):
    own.write_text("import sys\n" + SOURCE.replace("return 2 * x", "return 2 * x + 0 * sys.maxsize"))
    with pytest.warns(CompiledCodeWarning, match="twice uses 'sys'"):
        assert (loaded(own), loaded(own)) == (0, 0)


def test_a_docstring_that_is_a_constant_of_the_formula_too_counts(own):
    text = "from toolkit.foundation.kernel import kernel\n\n@kernel\ndef twice(x):\n    'ab'\n    return x * len('ab')\n"
    for length, edited in ((2, text), (3, text.replace("ab", "abc"))):
        own.write_text(edited)
        assert runpy.run_path(str(own))["twice"](1.0) == length


def test_commands_make_remarks_in_words_and_quiet_ones_make_none(monkeypatch):
    def remark(*_):
        warnings.warn("formulas are damaged.", CompiledCodeWarning, stacklevel=1)
        raise InputError("and no scene.")

    monkeypatch.setattr(cli, "read", remark)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        said = CliRunner().invoke(cli.app, ["statics", "scene.toml"]).stderr
    assert said == "note: formulas are damaged.\nand no scene.\n"
    scene = read_scene(PENDULUM)
    with (
        warnings.catch_warnings(record=True) as caught,
        at_work("steps", scene, "transient", quiet=True),
        pytest.raises(InputError),
    ):
        remark()
    assert caught == []
