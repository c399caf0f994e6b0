"""Compiled formulas on disk: one file for each kernel and types of its arguments, whole or not believed, wherever there is a place.

numba's own files end a program for ever when one of them is damaged, or when there is no place for them; and two programs that compile
one kernel for different types at the same time can leave the code of one under the name of the other.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
import tempfile
import warnings
from functools import cache, cached_property
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import llvmlite
import numba
import numpy as np

from toolkit.foundation.compiled.formula_stamp import CompiledFormula, Kernel, UnknownNameError, formula_stamp, layout
from toolkit.foundation.files.safe_files import in_one_stroke

if TYPE_CHECKING:
    from toolkit.foundation.compiled.numba_parts import CompileResult, JITCPUCodegen, Signature, cpu

VARIABLE = "NUMBA_CACHE_DIR"
"""Environment variable that names a folder for compiled code. numba also takes it from a file in the current folder, this program not:
what is loaded from there is executed."""
REMEDY = f"Set {VARIABLE} to a folder that lasts and can be written."
SETTINGS = ("BOUNDSCHECK", "OPT")
"""Settings of numba, from environment variables, that change the code."""
LAYOUT = 2
"""Version of the layout of what is kept; another number for another layout."""
_DIGEST = 32  # bytes of SHA-256, before the code
_TOLD: set[str] = set()  # kinds of remarks that this process has made


class CompiledCodeWarning(UserWarning):
    """Compiled formulas were damaged, or cannot be kept where they will be looked for the next time."""


class CompiledCode:
    """Store of one kernel's code; numba asks it for code before it compiles, and hands it the code afterwards.

    Parameters
    ----------
    kernel : the formula, as numba compiles it
    inner : whether only other kernels call it
    """

    cache_path = None
    """Folder that numba tells of, which here is one of several."""

    def __init__(self, kernel: Kernel, inner: bool = False) -> None:
        self.kernel, self.function, self._is_inner = kernel, kernel.py_func, inner

    def load_overload(self, signature: Signature, target: cpu.CPUContext) -> CompileResult | None:
        """Code that is kept for types of arguments; None if there is none, or only what is damaged."""
        from toolkit.foundation.compiled.numba_parts import restored

        file, damaged = self._file(signature, target.codegen()), None
        for folder in self._folders:
            try:
                _refuse_others(folder)
                content = (folder / file).read_bytes()
            except OSError:
                continue
            if content[:_DIGEST] == sha256(content[_DIGEST:]).digest():
                return restored(target, content[_DIGEST:], self._is_inner)
            damaged = folder
        if damaged:
            _tell("damaged", f"compiled formulas in {str(damaged)!r} are damaged; they are compiled again, once.")
        import_module("toolkit.foundation.compiled.written_code")  # for the compiler alone
        target.refresh()
        return None

    def save_overload(self, signature: Signature, compiled: CompiledFormula) -> None:
        """Keep the code in the first folder that takes it; say where it is if it does not last there."""
        from toolkit.foundation.compiled.numba_parts import bytes_of

        if any(not each.can_cache for each in compiled.lifted) or compiled.library.has_dynamic_globals:
            return
        code = bytes_of(compiled)
        content, file, refusals = sha256(code).digest() + code, self._file(signature, compiled.codegen), []
        for folder in self._folders:
            try:
                _make(folder)
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
        plain = f"{Path(self.function.__code__.co_filename).stem}.{self.function.__qualname__}".replace("<", "").replace(">", "")
        return f"{plain}.py{sys.version_info[0]}{sys.version_info[1]}"

    @cached_property
    def _stamp(self) -> str:
        """Hash of all that the code follows from; empty if nobody knows it, so that nothing can be kept."""
        try:
            return formula_stamp(self.kernel)
        except UnknownNameError as error:
            _tell(
                "unknown",
                f"{self.function.__qualname__} uses {error}, of which nobody knows what its code takes from it: every run compiles it "
                "again. Use numbers, arrays, named tuples and other kernels.",
            )
            return ""

    @cached_property
    def _folders(self) -> list[Path]:
        """Folders where code may be, the best place first."""
        if not self._stamp:
            return []
        source = Path(self.function.__code__.co_filename).absolute()
        name = f"{source.parent.name}_{sha256(str(source.parent).encode()).hexdigest()[:16]}"
        if given := os.environ.get(VARIABLE):
            return [Path(given).absolute() / name, *(folder / name for folder in _shared()[-1:])]
        beside = [source.parent / "__pycache__"] if source.is_file() else []
        return beside + [folder / name for folder in _shared()]

    def _file(self, signature: Signature, codegen: JITCPUCodegen) -> str:
        """Name of the file for types of arguments and a processor."""
        arguments = layout(getattr(signature, "args", signature))
        versions = (
            numba.__version__,
            llvmlite.__version__,
            np.__version__,
            *(getattr(numba.config, each, None) for each in SETTINGS),
        )
        key = repr((self._stamp, arguments, codegen.magic_tuple(), versions, self._is_inner, LAYOUT)).encode()
        return f"{self._name}-{sha256(key).hexdigest()[:16]}.nbc"


@cache
def _shared() -> list[Path]:
    """Folders that are not the program's own: one below the user's home, and last one that is emptied now and then."""
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
    """Refuse, by an OSError, a folder where somebody else could have put something: code that is loaded is executed."""
    if os.name == "posix" and folder.parent in _shared():
        found = folder.parent.lstat()
        if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid() or found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            raise PermissionError(errno.EPERM, "other users can write there")


def _make(folder: Path) -> None:
    """Make a folder for code, or refuse it by an OSError."""
    if folder.parent in _shared():
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        _refuse_others(folder)
    folder.mkdir(parents=True, exist_ok=True)


def folder_for(name: str) -> Path | None:
    """Folder of a name for code that numba keeps by itself; None, and a remark, if there is no place for it."""
    given, refusals = os.environ.get(VARIABLE), []
    for folder in [Path(given).absolute() / name] if given else [folder / name for folder in _shared()]:
        try:
            _make(folder)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError as error:
            refusals.append(f"{str(folder)!r} ({error.strerror or error})")
    _tell("kept", f"compiled formulas cannot be kept in {' or '.join(refusals)}: every run compiles them again. {REMEDY}")
    return None


def is_kept() -> bool:
    """Whether everything that was compiled so far stays where it will be found the next time."""
    return "kept" not in _TOLD


def _tell(kind: str, text: str) -> None:
    """Make a remark, but only the first of its kind: there are a hundred kernels."""
    if kind not in _TOLD:
        _TOLD.add(kind)
        warnings.warn(text, CompiledCodeWarning, stacklevel=2)
