"""Bases of all loads, which promise nothing about the space that they are in."""

from __future__ import annotations

from typing import ClassVar, Literal

from toolkit.description.description import InSpace
from toolkit.joints.rows import RowQuantity
from toolkit.markers.component import Component


class AnyLoad(InSpace):
    """Base of all loads: those on markers, and those on whole bodies and surfaces."""

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
        """Reference next to which the turn of the load's angle in space is taken, as an axis says nothing of turns.

        Where the turn is lost the torque jumps. None if the load feels no angle.
        """
        return None

    @property
    def state(self) -> RowQuantity | None:
        """Quantity that the load's own state is compared with, also as an integral over time; None without a state.

        It is a length or an angle; pure numbers count as angles.
        """
        return None
