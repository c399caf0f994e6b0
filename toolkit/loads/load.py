"""Bases of all loads, which promise nothing about the space that they are in."""

from __future__ import annotations

from typing import ClassVar, Literal

from toolkit.description.description import InSpace
from toolkit.joints.rows import RowQuantity
from toolkit.markers.component import Component


class AnyLoad(InSpace):
    """What acts on bodies: loads on markers, and those on whole bodies and surfaces."""

    siblings: ClassVar[str] = "PlanarLoad or SpatialLoad"
    proportional: ClassVar[tuple[str, ...]] = ()
    """Fields that it is proportional to, so that a load as large again is one of twice their numbers; none of a spring."""


class Load(AnyLoad, Component):
    """Forces and torques f(pose a, pose b, rates, parameters, curve value) on two markers.

    `formula(z, w, force, force_z, force_w)` (see `load_kernel`) fills f, f_z and f_w; the value of the time curve is its last argument.
    """

    leads: ClassVar[bool] = False
    """Whether its time curve leads, as that of a driver does, instead of being what grows with the loads."""

    @property
    def turn(self) -> Literal["zero", "state", "curve"] | None:
        """What the turn of its angle in space is next to, of which an axis says nothing: where it is lost the torque jumps."""
        return None

    @property
    def state(self) -> RowQuantity | None:
        """What its own state is compared with, also as an integral over time: a length or an angle (and pure numbers); None without one."""
        return None
