"""Kinds that are known because their files exist."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules


def import_room(name: str) -> None:
    """Import every module of a room and of those inside it, by name, so that every kind defined there can be named in a scene file.

    Rooms of compiled formulas, `kernels`, hold no kinds and are left alone.

    Parameters
    ----------
    name
        The room's dotted name, such as "toolkit.joints".
    """
    for found in iter_modules(import_module(name).__path__, f"{name}."):
        if not found.ispkg:
            import_module(found.name)
        elif not found.name.endswith(".kernels"):
            import_room(found.name)
