"""How far frequencies of a spin are off because linear FFRF lacks the stiffening of a body in its own frame.

Tension stiffens a beam; in a chain of bodies it does so at the joints between them, inside of a body it does not. Of a clamped uniform
beam that spins with Omega the square of the lowest frequency across the plane of the spin grows by 1.17 Omega^2, so that this frequency
grows by 0.58 (Omega / Omega_c)^2 parts of itself, with its critical speed Omega_c. A part of such a beam, clamped to the next one, that
carries the force N lacks

    0.21 mu,    mu = N L^2 / (3 E I) = N c^T K^-1 c / L,    c: deflection of one end of the part across the line to the other

of the lowest frequency of the whole, measured on chains of 2 to 16 bodies: to a factor of two or so.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.joints.joint import Joint
from toolkit.reduced_model.chord_condition import Chord
from toolkit.responses.forces.joint_force import JointForce
from toolkit.solvers.spin.generator import angular_velocity
from toolkit.system.flexible_bodies import deforming, design_point
from toolkit.system.solution import Solution
from toolkit.validity.bodies.spinning.critical_speed import critical_speed
from toolkit.validity.bodies.turning_frame import lateral_compliance

OF_SPEED, OF_TENSION = 0.58, 0.21
TOLD, DOUBTFUL = 0.005, 0.025
"""Parts of the lowest frequency above which it is told, and doubted: frequencies in the plane of the spin lack about twice as much."""


def missing_stiffening(solution: Solution) -> Iterator[Caution]:
    """A caution of the body whose frequencies lack most, of a steady spin."""
    omega = np.real(angular_velocity(solution.system, solution.q[-1], solution.v[-1]))
    speed = float(np.sqrt(omega @ omega))
    parts = {name: _part(solution, name, speed) for name in _flexible(solution)}
    worst = max(parts, key=lambda name: parts[name], default=None)
    if worst is None or not parts[worst] > TOLD:
        return
    part = parts[worst]
    lowers = f"by about {part:.1%}" if part < 1 else "by any amount"
    yield Caution(
        "missing-stiffening",
        f"centrifugal stiffening inside of {worst!r} is not in these numbers, which lowers the lowest frequency across the plane of the "
        f"spin {lowers}, and those in this plane by more. Linear FFRF stiffens a chain of bodies at the joints between them: make more "
        "bodies in a row of it; with twice as many a quarter of this is left.",
        doubt=part > DOUBTFUL,
    )


def _flexible(solution: Solution) -> list[str]:
    return [name for name, body in deforming(solution.system.scene).items() if body.turns]


def _part(solution: Solution, body: str, speed: float) -> float:
    scene = solution.system.scene
    gripped: dict[str, float] = {}
    for name, joint in scene.joints.items():
        for grip, point in joint.grips if isinstance(joint, Joint) else ():
            interface = getattr(scene.interface(point), "interface", None)
            if grip == body and interface in (design_point(scene, body).model.interfaces or {}):
                force = np.real(JointForce(joint=name, component="x").force(solution, 0)[0][: scene.dimension])
                gripped[interface] = max(gripped.get(interface, 0.0), float(np.sqrt(force @ force)))
    own = OF_SPEED * (speed / critical_speed(scene, body)) ** 2
    pairs = [Chord(one, other) for one in gripped for other in gripped if one < other]
    carried = [min(gripped[pair[0]], gripped[pair[1]]) * lateral_compliance(solution, body, pair) for pair in pairs]
    return own + OF_TENSION * max(carried, default=0.0)
