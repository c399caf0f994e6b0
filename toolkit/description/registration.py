"""Kinds that are known because their files exist."""

from __future__ import annotations

from importlib import import_module
from pkgutil import walk_packages


def import_room(name: str) -> None:
    """Import every module of a room and of those inside it, by name, so that every kind defined there can be named in a scene file.

    Parameters
    ----------
    name
        The room's dotted name, such as "toolkit.joints.planar".
    """
    for found in walk_packages(import_module(name).__path__, f"{name}."):
        import_module(found.name)
