"""All maps by name, and those that a scene has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import meant
from toolkit.foundation.units import UNIT_SYSTEMS
from toolkit.scene.scene import Scene
from toolkit.scene_file.conversion import converted
from toolkit.studies.stability.map import Axis, Map
from toolkit.studies.stability.physics_maps import PHYSICS
from toolkit.studies.stability.solver_maps import baumgarte_map, step_map

MAPS = ("step", "baumgarte", *PHYSICS, "units")


def unit_map(scene: Scene, directory: Path) -> Map:
    """The scene in every unit system; converted reduced models are written to a folder.

    Raises
    ------
    InputError
        The scene starts in a results file, whose numbers are in units of their own.
    """
    if scene.start_file is not None:
        raise InputError("it starts in a results file (solver.start), whose numbers are in units of their own")
    units = (scene.units, *(name for name in UNIT_SYSTEMS if name != scene.units))
    axis = Axis("units", units, 0)
    scenes: dict[tuple[int, ...], Scene] = {
        (k,): scene if k == 0 else converted(scene, name, directory) for k, name in enumerate(units)
    }
    return Map("units", "unit system", (axis,), scenes, "own units")


def maps_of(scene: Scene, names: Sequence[str] | None, directory: Path, most_steps: int) -> tuple[list[Map], dict[str, str]]:
    """The maps that were asked for, by default all that the scene has; and name -> why it has none of the others.

    Raises
    ------
    InputError
        A name is unknown, or the scene has nothing that this map varies.
    """
    unknown = [name for name in names or () if name not in MAPS]
    if unknown:
        raise InputError(f"unknown map {unknown[0]!r}{meant(unknown[0], MAPS)}; available: {', '.join(MAPS)}.")
    builders: dict[str, Callable[[Scene], Map]] = {
        "step": lambda each: step_map(each, most_steps),
        "baumgarte": baumgarte_map,
        **PHYSICS,
        "units": lambda each: unit_map(each, directory),
    }
    found, missing = [], {}
    for name in MAPS if names is None else dict.fromkeys(names):
        try:
            found.append(builders[name](scene))
        except InputError as error:
            if names is not None:
                raise InputError(f"there is no map {name!r} of this scene: {error}. Leave it out.") from error
            missing[name] = str(error)
    return found, missing
