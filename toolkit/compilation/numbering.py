"""Numbering of a scene: which unknown is whose. It depends on the scene's structure alone, never on its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from toolkit.bodies.body import QUATERNION
from toolkit.compilation.dependence import Affected, Item, affected_by, users_by_name
from toolkit.compilation.joint_forms import JointForms, joint_forms
from toolkit.foundation.errors import InputError
from toolkit.joints.joint import Joint
from toolkit.joints.rows import ROW_QUANTITIES
from toolkit.loads.load import Load
from toolkit.markers.component import Component
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene


@dataclass(frozen=True)
class Numbering:
    """Places of bodies among the coordinates, of joints among the multipliers, and the list of markers.

    Attributes
    ----------
    first
        Body -> number of its first coordinate; then path of a load with a state of its own -> number of that.
    row
        Joint -> number of its first multiplier among all unknowns.
    length
        Body -> number of the multiplier of its quaternion's length.
    markers
        (body, point) in the order of the marker arrays; a third entry is the path of the component whose axes it has.
    names
        What each unknown is, for messages.
    seen
        Markers that a response looks at.
    users
        Name -> items that name it, see `users_by_name`.
    joints
        The joints at any numbers, in the order of their rows.
    """

    first: dict[str, int]
    row: dict[str, int]
    length: dict[str, int]
    markers: tuple[tuple[str, ...], ...]
    names: tuple[str, ...]
    n_q: int
    seen: tuple[tuple[str, str], ...] = ()
    users: dict[str, list[Item]] = field(default_factory=dict)
    joints: tuple[Joint, ...] = ()

    @cached_property
    def forms(self) -> JointForms:
        """Forms of all joints of the scene."""
        return joint_forms(self.joints)

    def affected_by(self, scene: ResolvedScene, paths: Sequence[str]) -> Affected:
        """Items and markers that the numbers at some paths may change, in this scene at any numbers."""
        if (key := tuple(paths)) not in self._affected:
            self._affected[key] = affected_by(scene, self.markers, list(paths), self.users)
        return self._affected[key]

    @cached_property
    def _affected(self) -> dict[tuple[str, ...], Affected]:
        return {}

    @cached_property
    def row_lengths(self) -> np.ndarray:
        """Lengths that rows of joints, and the lengths of quaternions, are compared with: 1 for a length, nan for an angle."""
        rows = [np.nan if row.quantity == "angle" else 1.0 for each in self.forms.rows for row in each]
        return np.array([*rows, *(np.nan for _ in self.length)])

    @cached_property
    def runs(self) -> dict[Any, Any]:
        """Store of what `body_arrays` has found out about entries that are not zero in derivatives of the bodies' matrices."""
        return {}

    @cached_property
    def owners(self) -> dict[Affected | None, Any]:
        """Store of what `quantities.owners_of` has found."""
        return {}

    @property
    def n(self) -> int:
        """Number of unknowns, coordinates and multipliers."""
        return len(self.names)

    def marker(self, grip: tuple[str, ...]) -> int:
        """Number of the marker of a body at a point."""
        return self._numbers[grip]

    @cached_property
    def _numbers(self) -> dict[tuple[str, ...], int]:
        return {grip: m for m, grip in enumerate(self.markers)}

    @cached_property
    def states(self) -> np.ndarray:
        """Numbers of the coordinates that are states of loads."""
        return np.array([first for owner, first in self.first.items() if "." in owner], np.int64)

    def bodies_of(self, unknowns: np.ndarray) -> list[str]:
        """Bodies that have some of the unknowns as coordinates."""
        return [owner for owner in _owners(self.first, self.n_q, unknowns) if "." not in owner]

    def joints_of(self, unknowns: np.ndarray) -> list[str]:
        """Joints that have some of the unknowns as forces."""
        return _owners(self.row, min(self.length.values(), default=self.n), unknowns)


def _owners(first: dict[str, int], end: int, unknowns: np.ndarray) -> list[str]:
    """Names of the owners of some of the given unknowns; an owner's unknowns go from its first to the next one's."""
    edges = [*first.values(), end]
    return [
        name for name, low, high in zip(first, edges, edges[1:], strict=False) if np.any((low <= unknowns) & (unknowns < high))
    ]


def grips_of(path: str, component: Component) -> list[tuple[str, ...]]:
    """Markers of a component: (body, point), and its path if they have axes of its own."""
    own = () if component.axes is None else (path,)
    return [(*grip, *own) for grip in component.grips]


def number(scene: ResolvedScene, extra_markers: tuple[tuple[str, str], ...] = ()) -> Numbering:
    """Number the unknowns: bodies as in the scene, rows of joints, lengths of quaternions; `extra_markers` carry no component.

    Raises
    ------
    InputError
        A joint has more rows than a joint can have, or a row measures neither a length nor an angle.
    """
    names: list[str] = []
    first, row, length = {}, {}, {}
    for name, body in scene.all_bodies().items():
        first[name] = len(names)
        names += [f"{coordinate} of body {name!r}" for coordinate in body.coordinate_names(scene)]
    for path in _with_state(scene):
        first[path] = len(names)
        names.append(f"state of load {path.partition('.')[2]!r}")
    n_q = len(names)
    for name, joint in scene.joints.items():
        row[name] = len(names)
        if len(joint.rows) > scene.space.joint_rows:
            raise InputError(
                f"joint {name!r} has {len(joint.rows)} rows, a joint has at most {scene.space.joint_rows}. Split it into two."
            )
        for direction, quantity in joint.rows:
            if quantity not in ROW_QUANTITIES:
                raise InputError(
                    f"row {direction!r} of joint {name!r} measures {quantity!r}; a row is one of: {', '.join(ROW_QUANTITIES)}. Say which "
                    f"beside its name, in the class {type(joint).__name__}."
                )
        names += [f"{direction} of joint {name!r}" for direction in joint.row_names]
    for name in scene.pieces():
        if scene.body(name).turns == QUATERNION:
            length[name] = len(names)
            names.append(f"length of the quaternion of body {name!r}")
    loads = {f"loads.{name}": load for name, load in scene.loads.items() if isinstance(load, Load)}
    components: dict[str, Component] = {**{f"joints.{name}": joint for name, joint in scene.joints.items()}, **loads}
    grips = [grip for path, component in components.items() for grip in grips_of(path, component)]
    markers = tuple(dict.fromkeys([*grips, *extra_markers]))
    return Numbering(
        first, row, length, markers, tuple(names), n_q, tuple(extra_markers), users_by_name(scene), tuple(scene.joints.values())
    )


def _with_state(scene: Scene) -> dict[str, Load]:
    """Loads that have a state of their own, by their paths."""
    return {f"loads.{name}": load for name, load in scene.loads.items() if isinstance(load, Load) and load.state is not None}


def weights(scene: ResolvedScene, numbering: Numbering) -> np.ndarray:
    """Weights that make the unknowns comparable, (n,): displacement over the model size, or angle; free of units.

    For a coordinate it scales its change, for a multiplier the violation of its constraint row; states of loads are integrals over time,
    which all systems of units count in seconds.
    """
    states = [np.nan if load.state == "angle" else 1.0 for load in _with_state(scene).values()]
    bodies = [np.real(body.coordinate_lengths(scene)) for body in scene.all_bodies().values()]
    lengths = np.concatenate([*bodies, states, numbering.row_lengths])
    return np.where(np.isnan(lengths), 1.0, lengths / scene.size)
