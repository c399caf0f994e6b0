"""What a scene in space is made of: points, bodies, joints, loads, curves over time, responses; see `ffrf.plane`."""

from __future__ import annotations

from toolkit.api.plane import missing, parts_of_scenes

_PARTS = parts_of_scenes(3)
__all__ = list(_PARTS)


def __getattr__(name: str) -> type:
    """Class of a part of a scene, by its public name."""
    if name in _PARTS:
        return _PARTS[name]
    raise missing("ffrf.space", name, _PARTS)
