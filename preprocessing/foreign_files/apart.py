"""One guard around every reader of foreign files: a process of its own, and one error in words whatever happens there."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryFile
from typing import BinaryIO, NamedTuple

from preprocessing.foreign_files.child import LARGEST_FILE, Bounds
from preprocessing.foreign_files.wire import ReaderOutcome, Sent, receive
from toolkit.foundation.errors import InputError, without_content
from toolkit.foundation.files.safe_files import meant_path, size_of
from toolkit.foundation.processes import ONE_THREAD, command, environment, refuse_namesakes

CHILD = "from preprocessing.foreign_files.child import main; main(*sys.argv[1:])"


class ReaderEnded(NamedTuple):
    """End of a reader's process."""

    code: int | None  # negative: the signal that ended it; None: it was waited for in vain
    output: BinaryIO


def read_apart(reader: str, path: Path, how: str, remedy: str, *more: str, drawn: Sequence[Path] = ()) -> Sent:
    """Contents that one of the readers of `child` finds in a file, in a process of its own.

    Parameters
    ----------
    how, remedy : for the error: as what or by whom the file cannot be read, and what to do then
    more : further arguments of the reader
    drawn : files that the reader will draw on besides, which count for the bounds

    Raises
    ------
    InputError
        A file is no regular one or too large, its reader refuses it, fails, crashes, or takes more memory or time than any file of its
        size should.
    """
    bounds = Bounds.of(sum(bounded_size(each) for each in (path, *drawn)))
    ended = run(reader, path, bounds, *more)
    with ended.output as output:
        try:
            found = receive(output) if ended.code == 0 else ReaderOutcome()
        except ValueError:
            found = ReaderOutcome()
    if "found" in found:
        return found["found"]
    if "refused" in found:
        raise InputError(found["refused"])
    raise InputError(f"{str(path)!r} cannot be read {how} ({_why(ended, found, bounds)}). {_remedy(found) or remedy}")


def bounded_size(path: Path) -> int:
    """Size of a file in bytes, refused if it is too large.

    Raises
    ------
    InputError
        It is missing, no regular file, or larger than any file that is meant.
    """
    try:
        size = size_of(path)
    except FileNotFoundError as error:
        raise InputError(
            f"there is no file {str(path)!r}{meant_path(path, error)}. Fix the path; it is relative to the TOML file."
        ) from error
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read ({error.strerror}). Fix the path, or give a regular file.") from error
    if size > LARGEST_FILE:
        raise InputError(f"{str(path)!r} has {size} bytes, and more than {LARGEST_FILE} are not read. Give a smaller file.")
    return size


def run(reader: str, path: Path, bounds: Bounds, *more: str) -> ReaderEnded:
    """Run a reader in its process, and store what it sends."""
    refuse_namesakes()
    arguments = (reader, str(path), str(bounds.memory), str(bounds.seconds), *more)
    output = TemporaryFile()  # noqa: SIM115 (who asks reads and closes it: arrays come from there without a copy of them all)
    try:
        done = subprocess.run(
            command(CHILD, *arguments),
            env=environment() | ONE_THREAD,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.DEVNULL,
            timeout=bounds.patience,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return ReaderEnded(None, output)
    return ReaderEnded(done.returncode, output)


def _why(ended: ReaderEnded, found: ReaderOutcome, bounds: Bounds) -> str:
    """Reason why the process ended, in words."""
    if "reason" in found:
        return without_content(found["reason"]) or "it says nothing about why"
    if "lacks" in found:
        return f"reading this format needs {found['lacks']}, which cannot be loaded"
    if "memory" in found:
        return f"it claims more than it can hold: its reader needs more than {bounds.memory / 2**20:.0f} MiB"
    if ended.code is None or -ended.code == getattr(signal, "SIGXCPU", None):
        return f"its reader comes to no end within {bounds.seconds} s of work or {bounds.patience} s of waiting"
    if -ended.code == getattr(signal, "SIGKILL", None):
        return "the system ended its reader, as it does where memory is short"
    if ended.code < 0:
        return f"its reader crashed, {signal.Signals(-ended.code).name}"
    return "its reader failed"


def _remedy(found: ReaderOutcome) -> str:
    """Advice where a package is missing; empty otherwise."""
    if "lacks" not in found:
        return ""
    if found["lacks"] in ("meshio", "scipy", "numpy"):
        return "Install it with: pip install 'ffrf-toolkit[preprocessing]'."
    return "Install that package, or export another format."
