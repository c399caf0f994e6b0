"""Spatial Euler-Bernoulli beam elements, straight between their two nodes: linear along and in torsion, Hermite cubic across.

Nodal coordinates of an element: x, y, z and the rotations about these axes at its first end, then at its second, all in the global axes.
With r in [0, 1] along the element, L its length, e_1 its direction and e_2, e_3 the principal axes of its section,

    displacement of the centre line   u(r)  = e_1 a + e_2 v + e_3 w                   = S(r) u_e
    rotation of the section           th(r) = e_1 phi - e_2 w'/L + e_3 v'/L           = T(r) u_e
    a point e_k of the section off the centre line moves by              th x e_k     = R_k(r) u_e

with a and phi linear, v the Hermite cubic of the ends' displacements along e_2 and rotations about e_3, and w that of the displacements
along e_3 and rotations about -e_2. In the plane of e_1 and e_2 these are the functions of `beam`.

The offset of a point of the section is no displacement of the nodes. So that the places of all points are products with one vector, the
element has a 13th coordinate, the *offset*, which is one in the undeformed shape xi and zero in every displacement: the point at y_2, y_3
is at ([S, 0] + [R_2, e_2] y_2 + [R_3, e_3] y_3) [u_e; 1].

With shear (Timoshenko's beam) the section turns against the line by a strain gamma that is constant along the element,

    th of bending = v'/L - gamma,    gamma = Phi / (1 + Phi) ((v_2 - v_1) / L - (th_1 + th_2) / 2),    Phi = 12 E B / (kappa G A L^2)

B the second moment, and v is the Hermite cubic of the slopes th_i + gamma: exact between loads at the nodes. `phi` (n_e, 2) is Phi of
deflections along e_2 and e_3; without it there is no shear deformation.

Every function returns polynomial coefficients or matrices of all elements at once (first axis) for unit parameters of the section. Rotary
inertia of bending and torsion together is as the mass of the section's points has it. Without it the textbook matrices: Przemieniecki,
Theory of Matrix Structural Analysis (1968), chapters 5 and 11.
"""

from __future__ import annotations

import numpy as np

from toolkit.kinematics.beam_functions import AXIAL, HERMITE, POWERS

SECOND, THIRD = 1, 2
"""Numbers of the section's principal axes e_2 and e_3 among the axes of an element."""
_ORIENTATION = 1e-6
"""Sine of the angle between an element and the orientation of its section below which it says nothing."""
_TILTED = HERMITE[:, 1] + HERMITE[:, 3]
"""Powers of r in the deflection, in parts of the length, of slopes of one at both ends."""
Phi = np.ndarray | None
"""Of deflections along e_2 and e_3, (n_e, 2); None without shear."""


def length(ends: np.ndarray) -> np.ndarray:
    """Lengths (n_e,) of elements with ends (n_e, 2, 3)."""
    return np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1))


def axes(ends: np.ndarray, orientation: np.ndarray) -> np.ndarray:
    """Unit vectors e_1, e_2, e_3 as rows, (n_e, 3, 3).

    e_1 points from the first end to the second, e_3 is the orientation (n_e, 3) without its part along e_1, e_2 = e_3 x e_1. Complex where
    the ends are; the orientation must not be parallel to the element, see `parallel`.
    """
    along = (ends[:, 1] - ends[:, 0]) / length(ends)[:, None]
    third = orientation - (orientation * along).sum(axis=1)[:, None] * along
    third = third / np.sqrt((third**2).sum(axis=1))[:, None]
    return np.stack([along, np.cross(third, along), third], axis=1)


def parallel(ends: np.ndarray, orientation: np.ndarray) -> np.ndarray:
    """Which elements run along the orientation of their section, or have none: (n_e,) truth values."""
    size = np.linalg.norm(orientation, axis=1) * length(ends).real
    return np.linalg.norm(np.cross(np.real(ends[:, 1] - ends[:, 0]), orientation), axis=1) <= _ORIENTATION * size


def axial(ends: np.ndarray, triad: np.ndarray) -> np.ndarray:
    """Coefficients of r^k in the displacement a(r) along the element, (n_e, 4, 12)."""
    return _of_ends(triad[:, 0], AXIAL, 0)


def twist(ends: np.ndarray, triad: np.ndarray) -> np.ndarray:
    """Coefficients of r^k in the rotation phi(r) about the element, (n_e, 4, 12)."""
    return _of_ends(triad[:, 0], AXIAL, 3)


def transverse(ends: np.ndarray, triad: np.ndarray, axis: int, phi: Phi = None) -> np.ndarray:
    """Coefficients of r^k in the displacement v(r) or w(r) along e_2 or e_3 (`axis` SECOND or THIRD), (n_e, 4, 12)."""
    scaled = length(ends)[:, None] * _turning(triad, axis)
    found = _of_ends(triad[:, axis], HERMITE[:, 0::2], 0) + _of_ends(scaled, HERMITE[:, 1::2], 3)
    if phi is None:
        return found
    return found + (length(ends)[:, None] * shear_strain(ends, triad, axis, phi))[:, None, :] * _TILTED[:, None]


def _turning(triad: np.ndarray, axis: int) -> np.ndarray:
    """The axis about which a slope along `axis` turns, (n_e, 3)."""
    return triad[:, THIRD] if axis == SECOND else -triad[:, SECOND]


def shear_strain(ends: np.ndarray, triad: np.ndarray, axis: int, phi: np.ndarray) -> np.ndarray:
    """Row gamma of the strain by a shear force along `axis`, constant along the element, (n_e, 12)."""
    own, row = phi[:, axis - 1, None], np.zeros((len(ends), 12), np.result_type(triad, phi))
    for end, sign in ((0, -1), (6, 1)):
        row[:, end : end + 3] = sign * triad[:, axis] / length(ends)[:, None]
        row[:, end + 3 : end + 6] = -_turning(triad, axis) / 2
    return own / (1 + own) * row


def _of_ends(directions: np.ndarray, functions: np.ndarray, first: int) -> np.ndarray:
    """Coefficients (n_e, 4, 12) of functions (4, 2) of a component of the ends' displacements (`first` 0) or rotations (3)."""
    coefficients = np.zeros((len(directions), 4, 12), dtype=directions.dtype)
    coefficients[:, :, first : first + 3] = functions[:, 0, None] * directions[:, None, :]
    coefficients[:, :, first + 6 : first + 9] = functions[:, 1, None] * directions[:, None, :]
    return coefficients


def _slope(ends: np.ndarray, functions: np.ndarray) -> np.ndarray:
    """Coefficients of the derivative by the place along the element, (n_e, 4, 12)."""
    coefficients = np.zeros_like(functions)
    coefficients[:, :-1] = POWERS[1:, None] * functions[:, 1:]
    return coefficients / length(ends)[:, None, None]


def shape(ends: np.ndarray, triad: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Coefficients of r^k in the displacement S(r) of the centre line in global axes, (n_e, 4, 3, 12)."""
    parts = [axial(ends, triad), *(transverse(ends, triad, axis, phi) for axis in (SECOND, THIRD))]
    return sum(triad[:, None, k, :, None] * part[:, :, None, :] for k, part in enumerate(parts))


def rotation(ends: np.ndarray, triad: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Coefficients of r^k in the rotation T(r) of the section in global axes, (n_e, 4, 3, 12)."""
    parts = [twist(ends, triad), -_bent(ends, triad, THIRD, phi), _bent(ends, triad, SECOND, phi)]
    return sum(triad[:, None, k, :, None] * part[:, :, None, :] for k, part in enumerate(parts))


def _bent(ends: np.ndarray, triad: np.ndarray, axis: int, phi: Phi) -> np.ndarray:
    """Coefficients of r^k in the slope of the line less the strain of shear: what the section turns by, (n_e, 4, 12)."""
    found = _slope(ends, transverse(ends, triad, axis, phi))
    if phi is not None:
        found[:, 0] -= shear_strain(ends, triad, axis, phi)
    return found


def offset(ends: np.ndarray, triad: np.ndarray, axis: int, phi: Phi = None) -> np.ndarray:
    """Coefficients of r^k in [R_axis(r), e_axis], which moves a point of the section at a unit of e_axis, (n_e, 4, 3, 13)."""
    turned = np.cross(rotation(ends, triad, phi), triad[:, None, axis, :, None], axisa=2, axisb=2, axisc=2)
    coefficients = np.zeros((*turned.shape[:3], 13), dtype=turned.dtype)
    coefficients[..., :12] = turned
    coefficients[:, 0, :, 12] = triad[:, axis]
    return coefficients


def component_mass(ends: np.ndarray, triad: np.ndarray, phi: Phi = None) -> np.ndarray:
    """Component mass matrices M_ab = L int S_a^T S_b dr for unit mass per length, (n_e, 3, 3, 12, 12)."""
    return products(ends, shape(ends, triad, phi))


def rotary_mass(ends: np.ndarray, triad: np.ndarray, axis: int, phi: Phi = None) -> np.ndarray:
    """The same of the section's spread along e_axis, L int [R, e]_a^T [R, e]_b dr for unit rho int y_axis^2 dA, (n_e, 3, 3, 13, 13)."""
    return products(ends, offset(ends, triad, axis, phi))


def products(ends: np.ndarray, functions: np.ndarray) -> np.ndarray:
    """L int S_a^T S_b dr, (n_e, d, d, p, p), of functions by their coefficients of r^k, (n_e, 4, d, p).

    Exact, because int r^j r^k dr = 1 / (j + k + 1) on [0, 1].
    """
    moments = 1 / (POWERS[:, None] + POWERS + 1)
    integral = np.einsum("ejap,jk,ekbq->eabpq", functions, moments, functions, optimize=True)
    return length(ends)[:, None, None, None, None] * integral


def strain(ends: np.ndarray, triad: np.ndarray) -> np.ndarray:
    """Row eps = a'/L of the axial strain, constant along the element, (n_e, 12)."""
    return axial(ends, triad)[:, 1] / length(ends)[:, None]


def twist_rate(ends: np.ndarray, triad: np.ndarray) -> np.ndarray:
    """Row phi'/L of the twist per length, constant along the element, (n_e, 12)."""
    return twist(ends, triad)[:, 1] / length(ends)[:, None]


def curvature(ends: np.ndarray, triad: np.ndarray, axis: int, phi: Phi = None) -> np.ndarray:
    """Rows v''/L^2 or w''/L^2 (`axis` SECOND or THIRD) at both ends, (n_e, 2, 12); the strain at y_axis is -y_axis times it."""
    functions = transverse(ends, triad, axis, phi)
    at_ends = np.stack([2 * functions[:, 2], 2 * functions[:, 2] + 6 * functions[:, 3]], axis=1)
    return at_ends / length(ends)[:, None, None] ** 2


def stretching(ends: np.ndarray, triad: np.ndarray) -> np.ndarray:
    """Rows F (n_e, 1, 12) of the stiffness F^T F for unit E A."""
    return np.sqrt(length(ends))[:, None, None] * strain(ends, triad)[:, None]


def torsion(ends: np.ndarray, triad: np.ndarray) -> np.ndarray:
    """Rows F (n_e, 1, 12) of the stiffness F^T F for unit G J (Saint-Venant)."""
    return np.sqrt(length(ends))[:, None, None] * twist_rate(ends, triad)[:, None]


def bending(ends: np.ndarray, triad: np.ndarray, axis: int, phi: Phi = None) -> np.ndarray:
    """Rows F (n_e, 2, 12) of the stiffness F^T F for unit E int y_axis^2 dA.

    The curvature is linear along the element, and the integral of its square is that of its mean and of its difference between the ends,
    L (mean^2 + difference^2 / 12).
    """
    at_ends = curvature(ends, triad, axis, phi)
    rows = [at_ends.mean(axis=1), (at_ends[:, 1] - at_ends[:, 0]) / np.sqrt(12)]
    return np.sqrt(length(ends))[:, None, None] * np.stack(rows, axis=1)


def shearing(ends: np.ndarray, triad: np.ndarray, axis: int, phi: np.ndarray) -> np.ndarray:
    """Rows F (n_e, 1, 12) of the stiffness F^T F for unit kappa G A."""
    return np.sqrt(length(ends))[:, None, None] * shear_strain(ends, triad, axis, phi)[:, None]


def turning(ends: np.ndarray, triad: np.ndarray, axis: int, phi: Phi = None) -> np.ndarray:
    """Rows F (n_e, 3, 12) whose squares sum up to the integral of v'^2, or w'^2, along the element (`axis` SECOND or THIRD)."""
    powers = POWERS[:3]
    root = np.linalg.cholesky(1 / (powers[:, None] + powers + 1))  # a slope is quadratic, and int r^j r^k dr = 1 / (j + k + 1)
    slopes = _slope(ends, transverse(ends, triad, axis, phi))[:, :3]
    return np.sqrt(length(ends))[:, None, None] * np.einsum("jk,ejp->ekp", root, slopes)
