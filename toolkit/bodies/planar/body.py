"""Base of bodies in the plane, which says what the compilation asks of them; a new kind of body is one subclass."""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import numpy as np

from toolkit.bodies.body import Body


class MarkerNumbers(NamedTuple):
    """A point on a body: position z0 + Z c in the body, angle theta + t0 + T c since the undeformed configuration."""

    point: np.ndarray  # (3,) z0, t0
    columns: np.ndarray  # (n_columns,) numbers within the body's coordinates; 0, 1, 2 first if the body has a frame
    shape: np.ndarray  # (n_columns, 3) Z and T


class FloatingNumbers(NamedTuple):
    """Invariants of a flexible body with a moving frame; G, H and S on their common pattern."""

    mass: Any
    moment: np.ndarray  # (1 + n_f, 2) N^T
    row: np.ndarray
    column: np.ndarray
    inertia: np.ndarray
    gyroscopic: np.ndarray
    stiffening: np.ndarray  # S on the same entries; () of a body that no spin stiffens

    def times(self, factor: Any) -> FloatingNumbers:
        """All invariants times a factor, without the spin stiffening S."""
        return self._replace(
            mass=factor * self.mass,
            moment=factor * self.moment,
            inertia=factor * self.inertia,
            gyroscopic=factor * self.gyroscopic,
            stiffening=np.zeros(()),
        )

    @property
    def entries(self) -> int:
        """Number of entries of G, H and S and of the three rows and columns of the frame."""
        return len(self.row) + self.stiffening.size * (self.stiffening.ndim > 0) + 3 * (2 * len(self.moment) + 1)


class PlanarBody(Body):
    """Base of bodies in the plane. Coordinates are r_x, r_y, theta if the body has a frame, then the elastic ones."""

    dimension: ClassVar[int] = 2

    @property
    def has_frame(self) -> bool:
        """Whether the body's coordinates start with r_x, r_y, theta."""
        return True

    @property
    def moves(self) -> int:
        """Number of coordinates r_x, r_y of the frame's origin: 2, or 0 without a frame."""
        return 2 if self.has_frame else 0

    @property
    def turns(self) -> int:
        """Number of angles theta of the frame: 1, or 0 without a frame."""
        return 1 if self.has_frame else 0

    def frame_motion(self, _q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
        """Velocity of the frame's origin (2,) and angular velocity (1,), by keys of the body's table; empty without a frame."""
        return {"velocity": v[:2], "angular_velocity": v[2:3]} if self.has_frame else {}
