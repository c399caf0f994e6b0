"""Numbering of a scene: which unknown is whose. It depends on the scene's structure alone, never on its numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from toolkit.component import Component
from toolkit.errors import InputError
from toolkit.joints.joint_kernel import ROWS
from toolkit.loads.load import Load
from toolkit.scene import Scene


@dataclass(frozen=True)
class Numbering:
    """Places of bodies among the coordinates, of joints among the multipliers, and the list of markers.

    Attributes
    ----------
    first
        Body -> number of its first coordinate.
    row
        Joint -> number of its first multiplier among all unknowns.
    markers
        (body, point) in the order of the marker arrays.
    names
        What each unknown is, for messages.
    """

    first: dict[str, int]
    row: dict[str, int]
    markers: tuple[tuple[str, str], ...]
    names: tuple[str, ...]
    n_q: int

    @property
    def n(self) -> int:
        """Number of unknowns, coordinates and multipliers."""
        return len(self.names)

    def marker(self, grip: tuple[str, str]) -> int:
        """Number of the marker of a body at a point."""
        return self.markers.index(grip)


def number(scene: Scene, extra_markers: tuple[tuple[str, str], ...] = ()) -> Numbering:
    """Number the unknowns: bodies in the order of the scene, then the rows of the joints; `extra_markers` carry no component.

    Raises
    ------
    InputError
        A joint has more rows than a planar joint can have.
    """
    names: list[str] = []
    first, row = {}, {}
    for name, body in scene.all_bodies().items():
        first[name] = len(names)
        names += [f"{coordinate} of body {name!r}" for coordinate in body.coordinate_names(scene)]
    n_q = len(names)
    for name, joint in scene.joints.items():
        row[name] = len(names)
        if len(joint.row_names) > ROWS:
            raise InputError(
                f"joint {name!r} has {len(joint.row_names)} rows, a planar joint has at most {ROWS}. Split it into two."
            )
        names += [f"{direction} of joint {name!r}" for direction in joint.row_names]
    components: list[Component] = [*scene.joints.values(), *(load for load in scene.loads.values() if isinstance(load, Load))]
    grips = [grip for component in components for grip in component.grips]
    return Numbering(first, row, tuple(dict.fromkeys([*grips, *extra_markers])), tuple(names), n_q)


def weights(scene: Scene) -> np.ndarray:
    """What makes each unknown comparable, shape (n,): displacement over the scene's size, or angle; free of units.

    For a coordinate it scales its change, for a multiplier the violation of its constraint row.
    """
    size = scene.size
    lengths = np.concatenate([body.coordinate_lengths(scene) for body in scene.all_bodies().values()])
    rows = [np.nan if name == "rotation" else 1.0 for joint in scene.joints.values() for name in joint.row_names]
    lengths = np.concatenate([np.real(lengths), rows])
    return np.where(np.isnan(lengths), 1.0, lengths / size)
