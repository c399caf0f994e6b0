"""Base of all loads; a new load is one such class with its force law and the law's derivatives."""

from __future__ import annotations

from toolkit.markers.component import Component


class Load(Component):
    """Forces and torques f(pose a, pose b, rates, parameters, curve value) on two markers.

    `formula(z, w, force, force_z, force_w)` (see `load_kernel`) fills f, f_z and f_w; the value of the time curve is its last argument.
    """
