"""Compiled formulas on disk: one file for each kernel and types of its arguments, whole or not believed, wherever there is a place.

numba's own files end a program for ever when one of them is damaged, or when there is no place for them; and two programs that compile
one kernel for different types at the same time can leave the code of one under the name of the other.
"""

from __future__ import annotations

import errno
import inspect
import os
import pickle
import stat
import sys
import tempfile
import warnings
from collections.abc import Callable
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from toolkit.replaced_file import in_one_stroke

VARIABLE = "NUMBA_CACHE_DIR"
"""Environment variable that names a folder for compiled code. numba also takes it from a file in the current folder, this program not:
what is loaded from there is executed."""
REMEDY = f"Set {VARIABLE} to a folder that lasts and can be written."
_DIGEST = 32  # bytes of SHA-256, before the code
_TOLD: set[str] = set()  # kinds of remarks that this process has made


class CompiledCodeWarning(UserWarning):
    """Compiled formulas were damaged, or cannot be kept where they will be looked for the next time."""


class CompiledCode(NullCache):
    """What is kept of one kernel; numba asks it for code before it compiles, and hands it the code afterwards.

    Parameters
    ----------
    function : the formula as plain Python
    stamp : what else its code follows from
    """

    def __init__(self, function: Callable, stamp: str) -> None:
        self.function, self.stamp = function, stamp

    def load_overload(self, signature: Any, target: Any) -> CompileResult | None:
        """The code for types of arguments; None if there is none, or only what is damaged."""
        target.refresh()
        file, damaged = self._file(signature, target.codegen()), None
        for folder in self._folders:
            try:
                _refuse_others(folder)
                content = (folder / file).read_bytes()
            except OSError:
                continue
            if content[:_DIGEST] == sha256(content[_DIGEST:]).digest():
                return CompileResult._rebuild(target, *pickle.loads(content[_DIGEST:]))  # noqa: S301  trusted as the program is
            damaged = folder
        if damaged:
            _tell("damaged", f"compiled formulas in {str(damaged)!r} are damaged; they are compiled again, once.")
        return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep the code in the first folder that takes it; say where it is if it does not last there."""
        if any(not each.can_cache for each in compiled.lifted) or compiled.library.has_dynamic_globals:
            return
        code = dumps(compiled._reduce())
        content, file, refusals = sha256(code).digest() + code, self._file(signature, compiled.codegen), []
        for folder in self._folders:
            try:
                if folder.parent in _shared():
                    folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
                    _refuse_others(folder)
                folder.mkdir(parents=True, exist_ok=True)
                with in_one_stroke(folder / file) as temporary:
                    temporary.write_bytes(content)
            except OSError as error:
                refusals.append(f"{str(folder)!r} ({error.strerror or error})")
                continue
            if folder.parent == _shared()[-1]:
                lost = f"compiled formulas cannot be kept in {' or '.join(refusals)}"
                _tell("kept", f"{lost}; they are in {str(folder.parent)!r} until that is emptied. {REMEDY}")
            return
        if refusals:
            _tell("kept", f"compiled formulas cannot be kept in {' or '.join(refusals)}: every run compiles them again. {REMEDY}")

    @cached_property
    def _name(self) -> str:
        """Start of the names of the files."""
        code = self.function.__code__
        plain = f"{Path(code.co_filename).stem}.{self.function.__qualname__}".replace("<", "").replace(">", "")
        python = f"py{sys.version_info[0]}{sys.version_info[1]}"
        return f"{plain}-{code.co_firstlineno}.{python}-{sha256((self.stamp + self._source).encode()).hexdigest()[:16]}"

    @cached_property
    def _source(self) -> str:
        """Text that the formula stands in; empty if nobody knows it, so that nothing can be kept."""
        file = Path(self.function.__code__.co_filename)
        try:
            found = file.stat()
            return _text(file, found.st_mtime_ns, found.st_size)
        except (OSError, ValueError):
            pass
        try:
            return inspect.getsource(self.function)  # of a notebook
        except OSError:
            return ""

    @cached_property
    def _folders(self) -> list[Path]:
        """Where code may be, the best place first."""
        if not self._source:
            return []
        source = Path(self.function.__code__.co_filename).absolute()
        name = f"{source.parent.name}_{sha256(str(source.parent).encode()).hexdigest()[:16]}"
        if given := os.environ.get(VARIABLE):
            return [Path(given).absolute() / name, *(folder / name for folder in _shared()[-1:])]
        beside = [source.parent / "__pycache__"] if source.is_file() else []
        return beside + [folder / name for folder in _shared()]

    def _file(self, signature: Any, codegen: Any) -> str:
        """Name of the file for types of arguments, a processor, and what the formula is closed over."""
        cells = tuple(cell.cell_contents for cell in self.function.__closure__ or ())
        key = repr((str(signature), codegen.magic_tuple(), numba.__version__, llvmlite.__version__)).encode()
        key += self.function.__code__.co_code + (dumps(cells) if cells else b"")
        return f"{self._name}-{sha256(key).hexdigest()[:16]}.nbc"


@cache
def _text(file: Path, changed: int, size: int) -> str:
    """Content of a source file as of its last change."""
    return file.read_text(encoding="utf-8")


@cache
def _shared() -> list[Path]:
    """Folders that are not the program's own: below the home of the user; and one that is emptied now and then, the last."""
    user = os.geteuid() if os.name == "posix" else "user"
    try:
        lasting = [Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ffrf-toolkit"]
    except RuntimeError:  # there is no home
        lasting = []
    try:
        found = [*lasting, Path(tempfile.gettempdir()) / f"ffrf-toolkit-{user}"]
    except OSError:  # nothing can be written anywhere
        found = lasting
    return [folder for folder in found if folder.is_absolute()]


def _refuse_others(folder: Path) -> None:
    """Raise OSError where somebody else could have put something: code that is loaded is executed."""
    if os.name == "posix" and folder.parent in _shared():
        found = folder.parent.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid() or found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            raise PermissionError(errno.EPERM, "other users can write there")


def is_kept() -> bool:
    """Whether all that was compiled so far stays where it will be found the next time."""
    return "kept" not in _TOLD


def _tell(kind: str, text: str) -> None:
    """Make a remark, the first of its kind only: there are a hundred kernels."""
    if kind not in _TOLD:
        _TOLD.add(kind)
        warnings.warn(text, CompiledCodeWarning, stacklevel=2)
