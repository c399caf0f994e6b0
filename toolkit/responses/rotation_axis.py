"""The axis of an angle: needed in space, unknown in the plane."""

from __future__ import annotations

from typing import Any

from toolkit.foundation.errors import InputError


def refuse_axis(axis: Any | None, scene: Any, angle: str) -> None:
    """Refuse an axis in the plane, and an angle without one in space; `angle` is its name in words.

    Raises
    ------
    InputError
        The axis is missing, has no direction, or is one too many.
    """
    if scene.space.rotations_add != (axis is None) or (axis is not None and not any(axis)):
        raise InputError(
            f"a {angle} in space needs an `axis` with a direction, for example [0, 0, 1]; one in the plane has none."
        )
