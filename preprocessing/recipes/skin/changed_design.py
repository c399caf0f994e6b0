"""skin.toml with other values of some parameters: what a preprocessing at another design starts from."""

from __future__ import annotations

from typing import Any

from preprocessing.elements.section import QUANTITIES
from preprocessing.recipes.checked_file import put
from preprocessing.recipes.skin.skin_file import SkinFile
from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import meant

_KEYS = {
    "youngs_modulus": ("material", "youngs_modulus"),
    "density": ("material", "density"),
    "poisson_ratio": ("material", "poisson_ratio"),
    "thickness": ("section", "thickness"),
    "width": ("section", "width"),
    "damping_mass": ("damping", "mass"),
    "damping_stiffness": ("damping", "stiffness"),
    "chord": ("airfoil", "chord"),
    "y_scale": ("airfoil", "y_scale"),
}
"""Keys of the body's own parameters in skin.toml."""


def put_value(content: dict[str, Any], file: SkinFile, name: str, value: float) -> None:
    """Give a parameter of the file another value in its content.

    Besides the parameters of the reduced model, `interface_points.C.arc_length` puts an interface point elsewhere. Those of single
    elements, which `[skin] separate` makes, stand nowhere in the file and are left to `patches.distribute`.

    Raises
    ------
    InputError
        A parameter or interface point does not exist, or a value of a single element is invalid.
    """
    keys = _place(file, name)
    if keys and keys[0] == "interface_points":
        content["interface_points"][keys[1]] = {"arc_length": value}
    elif not keys and not (value > 0 or (value == 0 and name.startswith("damping"))):
        raise InputError(f"the parameter {name!r} cannot be {value!r}; give a positive number.")
    elif keys:
        put(content, keys, value)


def _place(file: SkinFile, name: str) -> tuple[str, ...]:
    """Keys that lead to a parameter in the file; empty for one of a single element."""
    if name in _KEYS:
        return _KEYS[name]
    if name in file.shape:
        return ("shape", name, "height")
    if name.startswith("interface_points.") and name.endswith(".arc_length"):
        point = name.split(".")[1]
        if point in file.interface_points:
            return ("interface_points", point)
    for quantity in QUANTITIES:
        owner = name.removeprefix(f"{quantity}_")
        if owner != name and owner in file.groups and quantity in file.groups[owner].values:
            return ("groups", owner, quantity)
        if owner in map(str, range(file.skin.elements)) and quantity in file.skin.separate:
            return ()
    raise InputError(
        f"skin.toml has no parameter {name!r}{meant(name, _KEYS)}; there are {', '.join(_KEYS)}, "
        f"shape modes ({', '.join(file.shape) or 'none'}), "
        f"quantities of groups such as thickness_NAME ({', '.join(file.groups) or 'no groups'}), of separate elements such as "
        "thickness_0, and interface_points.NAME.arc_length."
    )
