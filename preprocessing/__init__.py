"""From an airfoil, a mesh or beams to the reduced model of a flexible body.

    import preprocessing

    preprocessing.save(preprocessing.build("skin.toml"), "skin.h5")

Every name is loaded when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from preprocessing.builders.build_model import build, save
    from preprocessing.builders.frame_recipe import polygon_beam
    from preprocessing.elements.section import Section
    from preprocessing.projects.new_linkage import new_linkage
    from preprocessing.projects.new_solid import new_solid
    from preprocessing.projects.new_wing import new_wing

_SPEC, _OWN = find_spec("toolkit"), Path(__file__).resolve().parents[1] / "toolkit"
if _SPEC is None or _SPEC.origin is None or Path(_SPEC.origin).resolve().parent != _OWN:
    raise ImportError(
        f"'toolkit' is not the other half of this program, {str(_OWN)!r}, but {_SPEC and _SPEC.origin}, which comes before it on Python's "
        "path. Take its folder out of PYTHONPATH, or rename it."
    )

_PLACES = {
    "Section": "preprocessing.elements.section",
    "build": "preprocessing.builders.build_model",
    "new_linkage": "preprocessing.projects.new_linkage",
    "new_solid": "preprocessing.projects.new_solid",
    "new_wing": "preprocessing.projects.new_wing",
    "polygon_beam": "preprocessing.builders.frame_recipe",
    "save": "preprocessing.builders.build_model",
}
"""Name -> its module."""

__all__ = ["Section", "build", "new_linkage", "new_solid", "new_wing", "polygon_beam", "save"]


def __getattr__(name: str) -> object:
    if name not in _PLACES:
        raise AttributeError(f"preprocessing has no {name!r}; it has: {', '.join(_PLACES)}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_PLACES])
