"""What the shell offers while variables and paths are typed: the names that the scene has, and nothing where it cannot be read."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from toolkit.scene.scene import Scene


def variables(ctx: typer.Context, incomplete: str) -> list[str]:
    """Completions of the last of several variable names that are separated by commas."""
    before, comma, last = incomplete.rpartition(",")
    scene = _scene(ctx)
    known = [] if scene is None else [*scene.design, *scene.available_paths()]
    return [f"{before}{comma}{name}" for name in known if name.startswith(last)]


def changes(ctx: typer.Context, incomplete: str) -> list[str]:
    """Completions of `--set`: paths to numbers of the scene, and keys of its solver."""
    from toolkit.description.run_options import RunOptions

    scene = _scene(ctx)
    known = [] if scene is None else [*scene.available_paths(), *(f"solver.{key}" for key in RunOptions.model_fields)]
    return [f"{path}=" for path in known if path.startswith(incomplete)]


def _scene(ctx: typer.Context) -> Scene | None:
    """Scene named in the line being typed; None if there is none, or it cannot be read."""
    from toolkit.files.scene_reader import read_scene
    from toolkit.foundation.errors import ToolkitError

    given = [ctx.params.get(name) for name in ("scene", "file")]
    path = next((Path(each) for each in (*given, *_typed()) if each and Path(each).suffix == ".toml"), None)
    try:
        return None if path is None else read_scene(path)
    except (ToolkitError, OSError):
        return None


def _typed() -> list[str]:
    """Words of the line being typed, also those before the parsed ones."""
    return [*os.environ.get("COMP_WORDS", "").split(), *sys.argv[1:]]
