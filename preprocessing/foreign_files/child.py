"""The process that reads one file of another program: `main(reader, path, memory, seconds, ...)`, findings to its standard output."""

from __future__ import annotations

import os
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from importlib import import_module
from io import StringIO
from typing import TYPE_CHECKING, BinaryIO

from toolkit.foundation.errors import InputError
from toolkit.foundation.processes import limit_process, memory_of_machine

if TYPE_CHECKING:
    from preprocessing.foreign_files.wire import ReaderOutcome

LARGEST_FILE = 2 * 10**9
"""Bytes; a mesh of ten million nodes has half of it."""
BASE_MEMORY, MEMORY_PER_BYTE = 2**30, 50
"""Bytes of address space: the libraries alone take a third of the first, and a byte of text becomes 5 to 20 of Python's lists."""
BASE_SECONDS, SECONDS_PER_BYTE = 30, 1e-5
"""Processor time; the slowest readers, of text in Python, take 0.5 s for a million bytes."""
PATIENCE = 3
"""Times the processor time after which a reader that waits for something is ended."""


@dataclass(frozen=True)
class Bounds:
    """Limits of memory and time for one reader."""

    memory: int  # bytes of address space
    seconds: int  # of processor time

    @property
    def patience(self) -> int:
        """Longest time in seconds on the clock."""
        return PATIENCE * self.seconds

    @classmethod
    def of(cls, size: int) -> Bounds:
        """Limits for a file of this many bytes; never more memory than the machine has."""
        memory = BASE_MEMORY + MEMORY_PER_BYTE * size
        return cls(min(memory, memory_of_machine() or memory), int(BASE_SECONDS + SECONDS_PER_BYTE * size))

    def impose(self) -> None:
        """Put this process under them, where the system has such limits."""
        limit_process(self.memory, self.seconds)


READERS = {
    "mesh": ("preprocessing.foreign_files.mesh_reader", "mesh_contents"),
    "matrix": ("preprocessing.foreign_files.matrix_entries", "matrix_entries"),
    "table": ("preprocessing.foreign_files.number_files", "number_table"),
}
"""Name of a reader -> its module, of which only this process loads the libraries, and its function."""


def main(reader: str, path: str, memory: str, seconds: str, *more: str) -> None:
    """Read within the bounds, and send what was found or why nothing was."""
    Bounds(int(memory), int(seconds)).impose()
    with _own_output() as output:
        found = reading(reader, path, *more)
        from preprocessing.foreign_files.wire import send  # numpy, within the bounds

        try:
            send(output, found)
        except (TypeError, ValueError) as error:
            send(output, {"reason": str(error)})


def reading(reader: str, path: str, *more: str) -> ReaderOutcome:
    """Outcome of a reader, whatever happens to it."""
    said = StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            module, function = READERS[reader]
            return {"found": getattr(import_module(module), function)(path, *more)}
    except MemoryError:
        return {"memory": True}
    except InputError as error:
        return {"refused": str(error)}
    except ImportError as error:
        return {"lacks": error.name or str(error)}
    except RecursionError:
        return {"reason": "it is nested too deeply"}
    except (Exception, SystemExit) as error:  # noqa: BLE001 (readers raise anything, and some end the program)
        return {"reason": " ".join(f"{said.getvalue().rpartition('Error: ')[2]} {error}".split())[:2000]}


def _own_output() -> BinaryIO:
    """Standard output, to which from now on nothing else writes: libraries print what they like."""
    sys.stdout.flush()
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return output
