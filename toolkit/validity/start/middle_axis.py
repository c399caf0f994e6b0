"""Free rigid bodies that spin about the axis of their middle moment of inertia: what turns them over is hardly there at the start.

With the principal moments I_1 < I_2 < I_3 a spin omega about the second axis is unstable, and a small part of it across grows as

    exp(omega t sqrt((I_2 - I_1) (I_3 - I_2) / (I_1 I_3)))

A part that is written as zero, or as 1e-12, grows from round-off, or nearly so: nothing that is meant decides when the body turns over.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.bodies.body import QUATERNION
from toolkit.bodies.rigid import SpatialRigidBody
from toolkit.foundation.verdict import Caution, check
from toolkit.kinematics.orientation import angular_velocity
from toolkit.system.solution import Solution

MEANT = 1e-6
"""Part of a spin across its axis from which it is taken as meant: round-off is a tenth of a billionth of it."""
GROWTH = 100.0
"""Growth of a disturbance from which it is told, as of other motions that hardly anything sets off."""
STILL = 0.1
"""Part of the spin across the axis up to which the growth is that of a small one."""


@check("middle-axis", each_design=True)
def middle_spins(solution: Solution) -> Iterator[Caution]:
    """A free rigid body spins about the axis of its middle moment of inertia, and what turns it over is as small as round-off.

    Limit: growth by 100, and less than 1e-6 of the spin across the axis at the start.
    Fix: a disturbance that is meant in the body's `angular_velocity`, such as a thousandth of it.
    """
    scene = solution.system.scene
    held = {body for joint in scene.joints.values() for body, _ in joint.grips}
    for name, body in scene.bodies.items():
        if isinstance(body, SpatialRigidBody) and name not in held and body.turns == QUATERNION:
            aside, growth = _growth(solution, name, body)
            if aside < MEANT and growth > np.log(GROWTH):
                yield middle_spins.caution(
                    f"{name} spins about the axis of its middle moment of inertia. A disturbance grows {np.exp(growth):.2g} times in this "
                    f"motion, and {aside:.1g} of the spin lies across this axis at the start. Round-off decides whether and when it turns "
                    f"over. {middle_spins.fix}",
                )


def _growth(solution: Solution, name: str, body: SpatialRigidBody) -> tuple[float, float]:
    """Part of the spin that lies across the middle axis at the start, and the exponent by which it grows while it is small."""
    moments, axes = np.linalg.eigh(np.real(body.mass_properties(solution.system.scene)[2]))
    first, middle, last = moments.sum() - moments[::-1]
    where = solution.coordinates(name)
    turned = slice(where.start + body.moves, where.start + body.moves + QUATERNION)
    omega = angular_velocity(np.real(solution.q[:, turned]), np.real(solution.v[:, turned])) @ axes
    speed = np.linalg.norm(omega, axis=1)
    across = np.hypot(omega[:, 0], omega[:, 2])
    aside = np.divide(across, speed, out=np.ones(len(speed)), where=speed > 0)
    small = len(aside) if np.all(aside < STILL) else int(np.argmax(aside >= STILL))
    rate = speed * np.sqrt(max((middle - first) * (last - middle), 0.0) / (first * last)) if first > 0 else 0 * speed
    return float(aside[0]), float(np.trapezoid(rate[:small], solution.times[:small])) if small > 1 else 0.0
