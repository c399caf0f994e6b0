"""What pictures need of this machine."""

from __future__ import annotations

from importlib.util import find_spec

from toolkit.foundation.errors import ToolkitError


class RenderError(ToolkitError, RuntimeError):
    """Pictures cannot be drawn on this machine; the message says what to install."""


_EXTRA = {"imageio_ffmpeg": "film"}
"""Packages that do not come with the extra `render`."""


def require(*modules: str) -> None:
    """Refuse to go on without a package that pictures need."""
    for module in modules:
        if find_spec(module) is None:
            name, extra = module.replace("_", "-"), _EXTRA.get(module, "render")
            raise RenderError(f"pictures need {name}, which is not installed. Install: pip install 'ffrf-toolkit[{extra}]'.")
