"""From any file that describes a flexible body to its reduced model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.frame_recipe import FrameRecipe
from preprocessing.builders.recipe import Recipe, Remark
from preprocessing.builders.skin_recipe import SkinRecipe
from preprocessing.mesh.input_files import refuse_foreign
from toolkit.foundation.files.toml_file import read_toml, refuse_other
from toolkit.reduced_model.file import save as write
from toolkit.reduced_model.model import ReducedModel

RECIPES: tuple[type[Recipe], ...] = (FrameRecipe, BodyRecipe, SkinRecipe)
"""All kinds; a file is of the first that its content is meant as, and of the last if of none."""


def read_recipe(path: str | Path) -> Recipe:
    """Recipe from the file that describes a flexible body, of whatever kind it is.

    Raises
    ------
    InputError
        It is missing, no TOML, a scene, or a key is unknown, missing or has an invalid value; every such key is named.
    """
    *names, last = (kind.name for kind in reversed(RECIPES))
    content = read_toml(Path(path), f"a {', '.join(names)} or {last}")
    refuse_other(content, Path(path), "body")
    kind = next((kind for kind in RECIPES if kind.means(content)), RECIPES[-1])
    return kind.of(content, Path(path))


def build(
    path: str | Path,
    remark: Remark | None = None,
    values: Mapping[str, float] | None = None,
    keys: Mapping[str, object] | None = None,
) -> ReducedModel:
    """Build the reduced model that a skin.toml, body.toml or frame.toml describes.

    Parameters
    ----------
    path
        The file; what it names is sought from its folder.
    remark
        Called with every repair and every warning, in words.
    values
        Parameter -> value: another design than that of the file.
    keys
        Key -> value: another basis or mesh than that of the file, such as {"basis.count": 12}.

    Returns
    -------
    model
        The reduced model with all its derivatives; `save` writes it.

    Raises
    ------
    InputError
        The file, or one that it names, is missing or wrong; says what would be right.
    """
    return read_recipe(path).at(values, keys).build(remark)


def save(model: ReducedModel, path: str | Path) -> None:
    """Write a reduced model in one stroke: an interrupted run leaves the old file or none.

    Parameters
    ----------
    model
        What `build` or `polygon_beam` has returned.
    path
        The file, by custom ending in .h5. An older reduced model of that name is replaced.

    Raises
    ------
    InputError
        There is a file of that name that is no reduced model, or the place cannot be written to.
    ModelFileError
        The model is incomplete, or that of no body.
    """
    refuse_foreign(Path(path), "Name another file, or remove it.")
    write(model, path)
