"""From any file that describes a flexible body to its reduced model."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from preprocessing.recipes.skin.geometry import Remark
from preprocessing.recipes.source_file import source
from toolkit.reduced_model.model import ReducedModel


def build(
    path: str | Path,
    remark: Remark | None = None,
    values: Mapping[str, float] | None = None,
    keys: Mapping[str, Any] | None = None,
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
    return source(Path(path)).build(remark, values or {}, keys or {})
