"""skin.toml with other keys, such as another basis or another number of elements: the same skin, modelled otherwise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from preprocessing.recipes.checked_file import put, validated
from preprocessing.recipes.skin.skin_file import SkinFile
from toolkit.foundation.errors import InputError

ELEMENTS = "skin.elements"


def with_keys(file: SkinFile, keys: Mapping[str, Any], stations: Callable[[], Any]) -> SkinFile:
    """Skin file with other values of some keys.

    Parameters
    ----------
    keys : key -> value
        A table (`basis`), or a key in one (`skin.elements`). With another number of elements, interface points at nodes and groups
        of elements stay where they are along the skin.
    stations : callable
        Gives the arc lengths of the file's own nodes, (n_nodes,).

    Raises
    ------
    InputError
        A key or a value is invalid, or a group ends where no element of the other mesh does.
    """
    content = file.model_dump(exclude_none=True)
    if ELEMENTS in keys:
        _remesh(file, content, keys[ELEMENTS], stations)
    for key, value in keys.items():
        put(content, key.split("."), value)
    return validated(SkinFile, content, "the changed skin")


def _remesh(file: SkinFile, content: dict[str, Any], elements: int, stations: Callable[[], Any]) -> None:
    """Restate the interface points and groups that count nodes or elements."""
    own = file.skin.elements
    if file.skin.separate:
        raise InputError("skin.separate: quantities of single elements mean others in another mesh. Leave the key out.")
    for name, place in file.interface_points.items():
        if place.node is not None:
            moved, rest = divmod(place.node * elements, own)
            content["interface_points"][name] = {"arc_length": float(stations()[place.node])} if rest else {"node": moved}
    for name, group in file.groups.items():
        first, end = group.elements[0] * elements, (group.elements[1] + 1) * elements
        if first % own or end % own:
            raise InputError(
                f"groups.{name} ends where no element of a mesh of {elements} does. Choose a multiple of {own} elements."
            )
        content["groups"][name]["elements"] = [first // own, end // own - 1]
