"""Processes of their own: limits of memory and time, one thread of linear algebra, and programs of the preprocessing."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.machinery import PathFinder
from pathlib import Path
from typing import TYPE_CHECKING, Any

from toolkit.foundation.errors import InputError

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


ONE_THREAD = {name: "1" for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")}
"""Environment of such a process: threads take address space, which is limited, and readers need none."""


def limit_process(memory: int, seconds: int) -> None:
    """Limit this process to so many bytes of address space and seconds of processor time, where the system has such limits.

    None of its crashes leaves an image of its memory.
    """
    try:
        import resource
    except ImportError:  # Windows
        return
    limits = {"RLIMIT_AS": (memory,) * 2, "RLIMIT_CPU": (seconds, seconds + 5), "RLIMIT_CORE": (0, 0)}
    for name, limit in limits.items():
        with suppress(AttributeError, OSError, ValueError):  # not on this system, or a stricter one holds already
            resource.setrlimit(getattr(resource, name), limit)


def memory_of_machine() -> int:
    """Bytes of memory of the machine; 0 if it does not say."""
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return 0


SINGLE = {"OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Environment of a process whose linear algebra never starts threads; it has to be there before numpy is loaded."""


class _Limit(threading.local):
    """A limit of one thread, which the outermost block of a thread of the program sets and takes back.

    OpenBLAS keeps the limit for each thread of the program.
    """

    inside = 0
    set_by_us: Any = None

    def enter(self) -> None:
        """Enter one more block; the first one limits linear algebra to one thread."""
        if not self.inside and not _is_single():
            self.set_by_us = _controller().limit(limits=1, user_api="blas")
        self.inside += 1

    def leave(self) -> None:
        """Leave one block; the last one takes the limit back."""
        self.inside -= 1
        if not self.inside and self.set_by_us is not None:
            self.set_by_us.restore_original_limits()
            self.set_by_us = None


_LIMIT = _Limit()


@contextmanager
def one_thread() -> Iterator[None]:
    """Context or decorator in which the process's linear algebra (BLAS, LAPACK) has one thread.

    A factorisation of the wing's 140 equations takes 0.2 ms in one thread; in two that share their processors with other programs it was
    seen to take 150 ms. The outer one of nested blocks gives back as many threads as there were.
    """
    _LIMIT.enter()
    try:
        yield
    finally:
        _LIMIT.leave()


def _is_single() -> bool:
    return all(os.environ.get(name) == number for name, number in SINGLE.items())


@cache
def _controller() -> ThreadpoolController:
    """Controller of the threads of all libraries that scipy and numpy have loaded; looking for them takes some 20 ms."""
    import scipy.linalg  # noqa: F401, it brings one of them
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


HOME = Path(__file__).resolve().parents[2]
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


def is_installed() -> bool:
    """Whether there is a preprocessing of the same version to run."""
    return (HOME / "preprocessing" / "__init__.py").is_file()


def run(name: str, arguments: list[str], content: str | None = None) -> subprocess.CompletedProcess[str]:
    """Run a module of the preprocessing of the same version, with `content` as its input, and keep what it prints.

    Raises
    ------
    InputError
        The preprocessing is not installed, or another package has its name.
    """
    if not is_installed():
        raise InputError("this needs the preprocessing. Install it: pip install 'ffrf-toolkit[preprocessing]'.")
    command = program(name, *arguments)
    return subprocess.run(command, env=environment(), input=content, capture_output=True, text=True, check=False)
