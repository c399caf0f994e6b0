"""What the compilation asks of every body; a new kind of body is one subclass."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from toolkit.description.description import Registered
from toolkit.reduced_model.model import ReducedModel


class Placed(Protocol):
    """What a body may ask of its scene: where the points are, and its reduced model."""

    def position(self, point: str) -> np.ndarray:
        """Undeformed global position of a point, shape (2,)."""

    def interface(self, point: str) -> Any:
        """The point as the user wrote it."""

    def model(self, path: str, *parts: str) -> ReducedModel:
        """Parts of the reduced model of that file, relative to the scene's folder."""

    def arc_lengths(self, body: Any) -> dict[str, Any]:
        """Interface points of a body that the scene puts elsewhere along it, by their names in the reduced model."""


class MarkerNumbers(NamedTuple):
    """A point on a body: position z0 + Z c in the body, angle theta + t0 + T c since the undeformed configuration."""

    point: np.ndarray  # (3,) z0, t0
    columns: np.ndarray  # (n_columns,) numbers within the body's coordinates; 0, 1, 2 first if the body has a frame
    shape: np.ndarray  # (n_columns, 3) Z and T


class ConstantNumbers(NamedTuple):
    """Entries of constant mass, damping and stiffness matrices within the body's coordinates, and the force of gravity."""

    row: np.ndarray
    column: np.ndarray
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    force: np.ndarray  # (size,)


class FloatingNumbers(NamedTuple):
    """Invariants of a flexible body with a moving frame; G and H on their common pattern."""

    mass: Any
    moment: np.ndarray  # (1 + n_f, 2) N^T
    row: np.ndarray
    column: np.ndarray
    inertia: np.ndarray
    gyroscopic: np.ndarray


class Body(Registered):
    """Base of all bodies. Coordinates are r_x, r_y, theta if the body has a frame, then the elastic ones."""

    dimension: ClassVar[int] = 2

    @property
    def frame_size(self) -> int:
        """How many coordinates come before the elastic ones."""
        return 3 if self.has_frame else 0

    @property
    def turns(self) -> int:
        """How many coordinates its orientation has."""
        return 1 if self.has_frame else 0

    @property
    def has_frame(self) -> bool:
        """Whether the body's coordinates start with r_x, r_y, theta."""
        return True

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
    def coordinate_lengths(self, scene: Placed) -> np.ndarray:
        """Displacement that a unit of each coordinate stands for; nan for angles."""

    @abstractmethod
    def radius_of_gyration(self, scene: Placed) -> float:
        """sqrt(I / m) of the undeformed body about its frame's origin: its size, where points tell nothing."""

    @abstractmethod
    def marker(self, scene: Placed, point: str, name: str) -> Any:
        """The named point of the scene as a marker on this body."""

    @abstractmethod
    def constant(self, scene: Placed, gravity: np.ndarray) -> ConstantNumbers:
        """What is constant in the body's equations."""

    def floating(self, _scene: Placed) -> Any:
        """Invariants, if the body is flexible with a moving frame."""
        return None

    def model_values(self) -> Mapping[str, Any]:
        """Values of the parameters of the body's reduced model that the scene sets."""
        return {}
