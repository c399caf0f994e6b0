"""Missing stiffening of a body by its own spin: the tension that carries it round, where its frame's origin is off the axis.

Its model knows the centrifugal forces of a spin omega about its frame's origin. Where that is accelerated by a_0, or the centre of mass of
a body that floats about mean axes, joints carry another force m a_0 into the body. Of a clamped uniform beam

    omega_1^2 = omega_0^2 + (1.17 + 1.57 a / L) omega^2,    a = a_0 / omega^2,    L twice the distance of its centre of mass

is the square of the lowest frequency across the plane of the spin (Southwell and Gough 1921). A body that floats knows nothing of joints,
and no rule says how much that is.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from toolkit.bodies.cut.framed_part import FramedPart
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.reduced_model.model import MEAN_AXES
from toolkit.system.flexible_bodies import deforming, flexible_body, spins_of
from toolkit.system.solution import Solution
from toolkit.validity.bodies.spinning.critical_speed import critical_speed

OF_SPIN, OF_HUB = 1.17, 1.57
TOLD, DOUBTFUL = 0.005, 0.025
"""Missing parts of the lowest frequency above which there is a remark, or a doubt: in the plane of the spin, about twice as much
is missing."""
CARRIED = 0.01
"""Distance of the centre of mass from the axis, relative to the radius of gyration, from which joints carry a floating body."""


def stiffened(solution: Solution) -> list[str]:
    """Names of the bodies that ask for stiffening by their spin."""
    bodies = deforming(solution.system.scene).items()
    return [name for name, body in bodies if body.spin_stiffening and not isinstance(body, FramedPart)]


@check("missing-stiffening", (MOTION,))
def partly_stiffened(solution: Solution) -> Iterator[Caution]:
    """Cautions about bodies that lack a part of their stiffening at the instant of their fastest spin."""
    for body in stiffened(solution):
        spins = spins_of(solution, body)
        instant = first_largest(np.linalg.norm(spins, axis=1))
        part = off_the_axis(solution, body, spins[instant], instant)
        if part > TOLD:
            yield partly_stiffened.caution(told(body, part), doubt=part > DOUBTFUL)


def told(body: str, part: float) -> str:
    """Message about a body that lacks a part of its stiffening."""
    lowers = f"by about {part:.1%}" if part < 1 else "by any amount"
    return (
        f"the spin stiffens {body!r} by its own centrifugal forces about the origin of its frame, but not by the forces with which joints "
        f"carry it round, or that they carry on through it. That lowers the lowest frequency across the plane of the spin {lowers}. Fix: "
        "clamp its frame on the axis, or make more bodies in a row of it."
    )


def off_the_axis(solution: Solution, body: str, spin: np.ndarray, instant: int) -> float:
    """Part of the lowest frequency across the plane of a spin (3,) that a body lacks because its origin is off the axis."""
    speed = float(np.linalg.norm(spin))
    if speed == 0:
        return 0.0
    scene = solution.system.scene
    found: Any = flexible_body(scene, body)
    inv, where = found.invariants(scene), solution.coordinates(body)
    centre = np.zeros(3)
    centre[: scene.dimension] = np.real(inv.first_moment[:, 0] / inv.mass)
    pulled = np.real(solution.a[instant, where][: found.moves])
    if scene.model(found.model).reference_condition == MEAN_AXES:
        axes, inwards = found.frame_axes(np.real(solution.q[instant, where])), np.cross(spin, np.cross(spin, centre))
        radius = np.sqrt(np.real(inv.inertia_about_origin[0, 0] / inv.mass) - centre @ centre)
        carried = np.linalg.norm(pulled + axes @ inwards[: scene.dimension]) / speed**2
        return np.inf if carried > CARRIED * radius else 0.0
    length, away = 2 * float(np.linalg.norm(centre)), float(np.linalg.norm(pulled)) / speed**2
    fast = (speed / critical_speed(scene, body, spin, stiffened=False)) ** 2
    known = 1 + OF_SPIN * fast
    return 1 - float(np.sqrt(known / (known + OF_HUB * away / length * fast))) if length > 0 else 0.0
