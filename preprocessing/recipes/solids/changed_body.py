"""body.toml with other values of some parameters or keys: what a preprocessing at another design starts from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from preprocessing.recipes.skin.changed_content import put
from preprocessing.recipes.solids.body_file import BodyFile, body_from
from toolkit.foundation.errors import InputError

PLACES = {
    "youngs_modulus": "material.youngs_modulus",
    "density": "material.density",
    "poisson_ratio": "material.poisson_ratio",
    "width": "section.width",
    "damping_mass": "damping.mass",
    "damping_stiffness": "damping.stiffness",
}
"""Where the parameters of a body stand in body.toml, besides its shape variables."""


def changed_body(file: BodyFile, values: Mapping[str, float], keys: Mapping[str, Any], path: Path) -> BodyFile:
    """The file with other values.

    Parameters
    ----------
    values : parameter -> value
    keys : key -> value, a table (`basis`) or a key in one (`basis.count`)

    Raises
    ------
    InputError
        A parameter does not exist or has no place in the file, or a value cannot be meant.
    """
    if not values and not keys:
        return file
    if values and file.matrices is not None:
        raise InputError(
            f"{str(path)!r}: finished matrices hold for the values that they were made with. Change {', '.join(values)} in the scene, "
            "where the model follows it exactly, or export other matrices."
        )
    content = file.model_dump(exclude_none=True)
    places = {**PLACES, **{name: f"shape_variables.{name}.value" for name in file.shape_variables}}
    for name in values:
        if name not in places:
            raise InputError(f"{str(path)!r} has no parameter {name!r}; there are {', '.join(places)}.")
    for key, value in {**{places[name]: value for name, value in values.items()}, **keys}.items():
        put(content, key.split("."), value)
    return body_from(content, path)
