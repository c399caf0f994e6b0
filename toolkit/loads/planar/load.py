"""Bases of all loads in the plane; a new load is one such class with its force law and the law's derivatives."""

from __future__ import annotations

from typing import ClassVar

from toolkit.loads.load import AnyLoad, Load


class AnyPlanarLoad(AnyLoad):
    """Base of all loads on bodies in the plane."""

    dimension: ClassVar[int] = 2


class PlanarLoad(Load, AnyPlanarLoad):
    """Forces and torques f(pose a, pose b, rates, parameters, curve value) on two markers in the plane.

    `formula(z, w, force, force_z, force_w)` (see `load_kernel`) fills f, f_z and f_w; the value of the time curve is its last argument.
    z[0:3] and z[3:6] are x, y and angle of both markers; parameters begin at z[6].
    """
