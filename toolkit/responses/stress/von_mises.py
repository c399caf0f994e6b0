"""One stress for every stress point: that of a fibre, or von Mises' equivalent stress of six components.

With the components s = (xx, yy, zz, yz, xz, xy)

    sigma_vM^2 = s^T V s = ((xx - yy)^2 + (yy - zz)^2 + (zz - xx)^2) / 2 + 3 (yz^2 + xz^2 + xy^2)
"""

from __future__ import annotations

import numpy as np

V = np.zeros((6, 6))
V[:3, :3] = 1.5 * np.eye(3) - 0.5
V[3:, 3:] = 3 * np.eye(3)


def point_stress(components: np.ndarray) -> np.ndarray:
    """Stress of every point (...,) from its components (..., 1 or 6); complex-safe."""
    if components.shape[-1] == 1:
        return components[..., 0]
    xx, yy, zz, yz, xz, xy = np.moveaxis(components, -1, 0)
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (yz**2 + xz**2 + xy**2))


def point_slope(components: np.ndarray) -> np.ndarray:
    """Derivative of `point_stress` by the components, of the same shape; zero where there is no stress, and so no direction."""
    if components.shape[-1] == 1:
        return np.ones(components.shape)
    stress = point_stress(components)[..., None]
    return np.divide(components @ V, stress, out=np.zeros(components.shape, components.dtype), where=stress != 0)
