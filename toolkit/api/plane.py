"""What a scene in the plane is made of: points, bodies, joints, loads, curves over time, responses.

The names are those of the classes of all kinds that a scene file can name, without `Planar`, in space without `Spatial`.
"""

from __future__ import annotations

from toolkit.components.curves.catalogue import Curve
from toolkit.description.design import BodyPoint, Point
from toolkit.responses.catalogue import Response
from toolkit.scene.kinds import kinds_of


def parts_of_scenes(dimension: int) -> dict[str, type]:
    """Public name -> class, of all that a scene in the plane (2) or in space (3) can be made of and that the toolkit brings."""
    found: dict[str, type] = {"BodyPoint": BodyPoint, "Point": Point}
    for group in (*kinds_of(dimension).values(), Response.kinds, Curve.kinds):
        own = (kind for name, kind in group.items() if name != "ground" and kind.__module__.startswith("toolkit."))
        found |= {kind.__name__.removeprefix("Planar").removeprefix("Spatial"): kind for kind in own}
    return dict(sorted(found.items()))


def missing(place: str, name: str, parts: dict[str, type]) -> AttributeError:
    """Error for a name that is not there, which lists those that are."""
    return AttributeError(f"{place} has no {name!r}; it has: {', '.join(parts)}")


_PARTS = parts_of_scenes(2)
__all__ = list(_PARTS)


def __getattr__(name: str) -> type:
    """Class of a part of a scene, by its public name."""
    if name in _PARTS:
        return _PARTS[name]
    raise missing("ffrf.plane", name, _PARTS)
