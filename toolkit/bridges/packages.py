"""The packages on the other side of the bridges, imported when a bridge is asked for."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from toolkit.foundation.errors import ToolkitError


class BridgeError(ToolkitError, RuntimeError):
    """A bridge leads to a package that is not installed, or is not set up as it must be; the message says what to do."""


def package(name: str, extra: str) -> Any:
    """A package of the other side.

    Raises
    ------
    BridgeError
        It is not installed; says how to.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise BridgeError(
            f"this bridge needs {name}, which cannot be imported ({error}). Install: pip install 'ffrf-toolkit[{extra}]'."
        ) from error
