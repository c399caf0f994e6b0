"""Pictures of studies on the command line: drawn where that can be done, and said where not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from toolkit.render.packages import RenderError, require

if TYPE_CHECKING:
    from toolkit.report.drawing import Drawing


def save_drawing(drawn: Callable[[], Drawing], folder: Path, quiet: bool) -> list[Path]:
    """Files of a saved drawing; none, with a note, where matplotlib is not installed."""
    try:
        require("matplotlib")
    except RenderError as error:
        if not quiet:
            typer.echo(f"no picture: {error}", err=True)
        return []
    return drawn().save(folder)
