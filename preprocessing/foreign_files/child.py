"""The process that reads one file of another program: `main(reader, path, memory, seconds, ...)`, findings to its standard output."""

from __future__ import annotations

import os
import sys
from contextlib import redirect_stderr, redirect_stdout
from importlib import import_module
from io import StringIO
from typing import Any, BinaryIO

from preprocessing.foreign_files.bounds import Bounds
from toolkit.foundation.errors import InputError

READERS = {
    "mesh": ("preprocessing.foreign_files.mesh_reader", "mesh_contents"),
    "matrix": ("preprocessing.foreign_files.matrices.matrix_entries", "matrix_entries"),
    "table": ("preprocessing.foreign_files.matrices.number_table", "number_table"),
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


def reading(reader: str, path: str, *more: str) -> dict[str, Any]:
    """Outcome of a reader: what was `found`, or why nothing was.

    The reason is `refused` in words of our own, the `reason` why a library found nothing, a package that it `lacks`, or `memory`.
    """
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
