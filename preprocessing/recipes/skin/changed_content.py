"""Other values at the keys of an input file's content, and the skin that it then describes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import ValidationError

from preprocessing.recipes.skin.skin_file import SkinFile, explain
from toolkit.foundation.errors import InputError


def put(content: dict[str, Any], keys: Sequence[str], value: Any) -> None:
    """Set a table (`basis`), or a key in one (`skin`, `elements`)."""
    *tables, last = keys
    table: Any = content
    for name in tables:
        table = table.setdefault(name, {})
    table[last] = value


def skin_from(content: dict[str, Any], what: str) -> SkinFile:
    """The skin of a changed content; `what` was changed.

    Raises
    ------
    InputError
        A key or a value cannot be meant.
    """
    try:
        return SkinFile.model_validate(content)
    except ValidationError as error:
        raise InputError(f"the changed {what} cannot be used:\n" + "\n".join(explain(item) for item in error.errors())) from error
