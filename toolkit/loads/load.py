"""Bases of all loads, which promise nothing about the space that they are in."""

from __future__ import annotations

from toolkit.description.description import Registered
from toolkit.markers.component import Component


class AnyLoad(Registered):
    """What acts on bodies: loads on markers, and those on whole bodies and surfaces."""


class Load(AnyLoad, Component):
    """Forces and torques f(pose a, pose b, rates, parameters, curve value) on two markers.

    `formula(z, w, force, force_z, force_w)` (see `load_kernel`) fills f, f_z and f_w; the value of the time curve is its last argument.
    """
