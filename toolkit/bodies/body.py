"""Base of all bodies, which says what the compilation asks of every body; a new kind of body is one subclass."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Hashable, Mapping
from typing import Any, ClassVar, NamedTuple, Protocol, TypeVar

import numpy as np

from toolkit.bodies.chain_strains import Strains, no_strains
from toolkit.description.description import InSpace
from toolkit.reduced_model.model import ReducedModel

T = TypeVar("T")
CENTRE = "(centre of mass)"
"""Name in place of a point of the scene: a body's centre of mass, which moves in a body that deforms."""
QUATERNION = 4
"""Coordinates of an orientation that has a length to keep."""


class Placed(Protocol):
    """Interface of a scene to its bodies: where the points are, and the bodies' reduced models."""

    @property
    def bodies(self) -> Mapping[str, Any]:
        """All bodies but the ground, by name."""

    def position(self, point: str) -> np.ndarray:
        """Undeformed global position of a point, shape (d,)."""

    def interface(self, point: str) -> Any:
        """Description of a point as the user wrote it."""

    def model(self, path: str, *parts: str) -> ReducedModel:
        """Parts of the reduced model in a file, whose path is relative to the scene's folder."""

    def arc_lengths(self, body: Any) -> dict[str, Any]:
        """Interface points of a body that the scene puts elsewhere along it, by their names in the reduced model."""

    def of_body(self, body: Any, what: Hashable, make: Callable[[], T]) -> T:
        """Result of a computation for one body of the scene; a scene that remembers its answers has it made once."""


class ConstantNumbers(NamedTuple):
    """Entries of constant mass, damping and stiffness matrices within the body's coordinates, and the force of gravity."""

    row: np.ndarray
    column: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray  # (size,)
    strains: Strains = no_strains()  # the same stiffness in its factors, where these are known


class Body(InSpace):
    """Base of all bodies. Coordinates are those of the origin of its frame, then those of its orientation, then the elastic ones."""

    siblings: ClassVar[str] = "PlanarBody or SpatialBody"
    proportional: ClassVar[tuple[str, ...]] = ()
    """Fields that mass and moments of inertia are proportional to, of a body that does not deform."""

    @property
    @abstractmethod
    def moves(self) -> int:
        """Number of coordinates of the frame's origin."""

    @property
    @abstractmethod
    def turns(self) -> int:
        """Number of coordinates of the frame's orientation."""

    @property
    def frame_size(self) -> int:
        """Number of the frame's coordinates, which come before the elastic ones."""
        return self.moves + self.turns

    @property
    def has_frame(self) -> bool:
        """Whether the body has coordinates of a frame, which come before the elastic ones."""
        return self.frame_size > 0

    def named_points(self) -> tuple[str, ...]:
        """Points of the scene that the body is built on."""
        return ()

    @abstractmethod
    def coordinate_names(self, scene: Placed) -> list[str]:
        """Names of the coordinates, for messages; their number is the body's size."""

    @abstractmethod
    def initial_state(self, scene: Placed) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and velocities at the start."""

    def written_velocities(self) -> dict[int, str]:
        """Coordinates whose velocity at the start is written, so that it holds -> key of the body's table that says so.

        The velocities of all others, whatever `initial_state` gives them, are where the search for velocities that fit begins.
        """
        return {}

    @abstractmethod
    def frame_motion(self, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """Motion of the frame in the numbers that a scene writes: key of the body's table -> numbers, as far as the frame moves.

        From the body's coordinates q and velocities v: "velocity" (d,) of the frame's origin, "angular_velocity" in rad/time, (1,) in the
        plane, in space (3,) in the axes of space.
        """

    @abstractmethod
    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """Displacement that a unit of each coordinate stands for; nan for angles."""

    @abstractmethod
    def radius_of_gyration(self, scene: Placed) -> float:
        """sqrt(I / m) of the undeformed body about its frame's origin: its size, where points tell nothing."""

    @abstractmethod
    def marker(self, scene: Placed, point: str, name: str) -> Any:
        """Marker on this body at the named point of the scene."""

    @abstractmethod
    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """Constant terms of the body's equations of motion."""

    @abstractmethod
    def whole_mass(self, scene: Placed) -> Any:
        """Mass of the body."""

    def floating(self, _scene: Placed) -> Any:
        """Invariants of a flexible body with a moving frame; None of other bodies."""
        return None

    def drag(self, _scene: Placed) -> Any:
        """Invariants of a moving frame, each times the body's mass-proportional damping; None if it has neither."""
        return None

    def model_values(self) -> Mapping[str, Any]:
        """Values of the parameters of the body's reduced model that the scene sets."""
        return {}


def no_constants(size: int) -> ConstantNumbers:
    """Constant terms without entries, for a body of this size all of whose terms move with its frame."""
    empty = np.zeros(0, int)
    return ConstantNumbers(empty, empty, np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(size))
