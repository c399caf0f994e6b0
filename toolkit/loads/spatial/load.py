"""Bases of all loads in space; a new load is one such class with its force law and the law's derivatives."""

from __future__ import annotations

from typing import ClassVar

from toolkit.loads.load import AnyLoad, Load


class AnySpatialLoad(AnyLoad):
    """Base of all loads on bodies in space."""

    dimension: ClassVar[int] = 3


class SpatialLoad(Load, AnySpatialLoad):
    """Forces f(pose a, pose b, rates, parameters, curve value) on two markers, conjugate to their poses of four vectors.

    `formula(z, w, force, force_z, force_w)` (see `load_kernel`) fills f, f_z and f_w; the value of the time curve is its last argument,
    z[SPATIAL_CURVE]. z[0:3] and z[12:15] are the positions, then follow the three axes of each marker; parameters begin at z[24].
    """
