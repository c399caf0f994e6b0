"""gmsh, loaded only where a mesh is wanted, and a model of our own in its one global state."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from toolkit.foundation.errors import InputError


def load_gmsh() -> Any:
    """Module gmsh, loaded when a mesh is wanted.

    Raises
    ------
    InputError
        It is not installed, or lacks a system library.
    """
    try:
        return import_module("gmsh")
    except (ImportError, OSError) as error:
        raise InputError(
            f"meshing needs gmsh, which cannot be loaded ({error}). Install it with: pip install "
            "'ffrf-toolkit[preprocessing]'; its system libraries on Debian: apt-get install libglu1-mesa libgl1 libxcursor1 libxft2 "
            "libxinerama1 libgomp1"
        ) from error


@contextmanager
def gmsh_model(name: str) -> Iterator[Any]:
    """Context with a gmsh model of our own, which leaves a gmsh session of the caller as it was; gives the module."""
    gmsh = load_gmsh()
    if gmsh.isInitialized():
        current = gmsh.model.getCurrent()
        terminal = gmsh.option.getNumber("General.Terminal")
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(name)
        try:
            yield gmsh
        finally:
            gmsh.model.remove()
            gmsh.option.setNumber("General.Terminal", terminal)
            if current:
                gmsh.model.setCurrent(current)
        return
    # gmsh's own signal handler would survive finalize and make Ctrl-C kill Python
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(name)
        yield gmsh
    finally:
        gmsh.finalize()
