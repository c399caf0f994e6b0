"""A random scene by its seed."""

from __future__ import annotations

from pathlib import Path

from tests.random_scenes import planar, spatial
from tests.random_scenes.draft import Draft
from tests.random_scenes.draw import Draw
from tests.random_scenes.solver import random_options
from toolkit.scene.scene import Scene

PLANAR_PART = 0.5


def random_scene(seed: int, directory: Path) -> Scene:
    """The scene of a seed, with reduced models in `directory`, where those that are missing are built."""
    return named_scene(seed, directory)[1]


def named_scene(seed: int, directory: Path) -> tuple[str, Scene]:
    """What kind of scene it is, and the scene."""
    draw = Draw(seed)
    dimension = 2 if draw.chance(PLANAR_PART) else 3
    kinds = planar.KINDS if dimension == 2 else spatial.KINDS
    kind = draw.one(list(kinds))
    draft = Draft(draw, directory, dimension)
    kinds[kind](draft)
    return f"{kind} {dimension}D", draft.scene(random_options(draft))
