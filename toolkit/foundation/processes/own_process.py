"""Python in processes of their own, in which nothing is executed that happens to lie in the current folder."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import PathFinder
from pathlib import Path

from toolkit.foundation.errors import InputError

HOME = Path(__file__).resolve().parents[3]
"""Folder that holds both halves of the program."""
SAFE = "PYTHONSAFEPATH"
"""Environment variable that keeps Python from looking for modules in the current folder first."""


def safe_path() -> list[str]:
    """Folders where this process looks for modules, without the current one, which `python -c` and `python -m` put first."""
    foreign = {os.path.realpath(os.curdir)} - {str(HOME)}
    found = [entry for entry in sys.path if os.path.isabs(entry) and os.path.realpath(entry) not in foreign]
    return found if str(HOME) in found else [*found, str(HOME)]


def command(code: str, *arguments: str) -> list[str]:
    """Command line that runs a text of Python; to be started in the `environment` of this module."""
    return [sys.executable, "-P", "-c", f"import sys; sys.path[:] = {safe_path()!r}\n{code}", *arguments]


def program(name: str, *arguments: str) -> list[str]:
    """Command line that runs a module of the program.

    Raises
    ------
    InputError
        Another package of the same name would be found before it.
    """
    refuse_namesakes()
    return command(f"import runpy; runpy.run_module({name!r}, run_name='__main__', alter_sys=True)", *arguments)


def environment() -> dict[str, str]:
    """Environment of such processes; what PYTHONPATH holds is in their path already, unless it begins at the current folder."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | {SAFE: "1"}


@contextmanager
def safe_spawning() -> Iterator[None]:
    """Context in which `multiprocessing` starts Python in this environment, for as long as it lasts.

    It hands on the path by itself.
    """
    before = {name: os.environ.pop(name, None) for name in (SAFE, "PYTHONPATH")}
    os.environ[SAFE] = "1"
    try:
        yield
    finally:
        del os.environ[SAFE]
        os.environ.update({name: value for name, value in before.items() if value is not None})


def refuse_namesakes() -> None:
    """Refuse a foreign package with the name of one of the program's own before it on Python's path.

    Raises
    ------
    InputError
        Names both.
    """
    for name in ("toolkit", "preprocessing"):
        spec = PathFinder.find_spec(name, safe_path())
        found = Path(spec.origin).resolve().parent if spec and spec.origin else None
        if found and found != HOME / name:
            raise InputError(
                f"{str(found)!r} has the name of a part of this program, {str(HOME / name)!r}, and comes before it on Python's path. Take "
                "its folder out of PYTHONPATH, or rename it."
            )
