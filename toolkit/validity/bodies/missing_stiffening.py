"""How far frequencies of a spin are off because linear FFRF lacks the stiffening of a body in its own frame.

Missing stiffening of a body by its own spin: the tension that carries it round, where its frame's origin is off the axis.

Its model knows the centrifugal forces of a spin omega about its frame's origin. Where that is accelerated by a_0, or the centre of mass of
a body that floats about mean axes, joints carry another force m a_0 into the body. Of a clamped uniform beam

    omega_1^2 = omega_0^2 + (1.17 + 1.57 a / L) omega^2,    a = a_0 / omega^2,    L twice the distance of its centre of mass

is the square of the lowest frequency across the plane of the spin (Southwell and Gough 1921). A body that floats knows nothing of joints,
and no rule says how much that is.

Tension stiffens a beam; in a chain of bodies it does so at the joints between them, inside of a body it does not. Of a clamped uniform
beam that spins with Omega the square of the lowest frequency across the plane of the spin grows by 1.17 Omega^2, so that this frequency
grows by 0.58 (Omega / Omega_c)^2 parts of itself, with its critical speed Omega_c. A part of such a beam, clamped to the next one, that
carries the force N lacks

    0.21 mu,    mu = N L^2 / (3 E I) = N c^T K^-1 c / L,    c: deflection of one end of the part across the line to the other

of the lowest frequency of the whole, measured on chains of 2 to 16 bodies: to a factor of two or so.

The parts of a cut body have their frames on chords, which stiffen by themselves. What a part of length L lacks is the work of N on the
slopes against its chord, N L^3 k^2 / 24 with the curvature k. With mu of the parts, mu_w of the whole and the parts f of the energy of
bending that each of them has, that is

    (sum mu f) / 8 / (1 + 0.57 mu_w)  across the plane of the spin,    (sum mu f) / 8 / (1 + 0.083 mu_w)  in this plane

of the lowest frequencies, measured on 2 to 16 equal parts and up to 10 sqrt(E I / rho A) / L^2, to a factor of 1.5: their squares are
those at rest and 1.17 and 0.17 Omega^2. A body that is free at one end bends as a cantilever under a uniform load, any other one
everywhere alike.
Of a body that its own spin stiffens see `partly_stiffened`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.framed_part import FramedPart
from toolkit.components.joints.joint import Joint
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import MOTION, SPIN, Caution, check
from toolkit.reduced_model.cut_part import FIRST, LAST
from toolkit.reduced_model.model import MEAN_AXES, Chord
from toolkit.responses.least_squares_forces import wrenches_of_joints
from toolkit.scene.resolution import ResolvedScene
from toolkit.solvers.spin_axis import angular_velocity
from toolkit.system.solution import Solution, deforming, design_point, flexible_body, spins_of
from toolkit.validity.bodies.carried_force import bending_compliance, lateral_compliance
from toolkit.validity.bodies.critical_speed import critical_speed

OF_SPIN, OF_HUB = 1.17, 1.57
REMARK_PART, DOUBT_PART = 0.005, 0.025
"""Missing parts of the lowest frequency above which there is a remark, or a doubt: in the plane of the spin, about twice as much
is missing."""
CARRIED_DISTANCE = 0.01
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
        if part > REMARK_PART:
            yield partly_stiffened.caution(told(body, part), doubt=part > DOUBT_PART)


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
        return np.inf if carried > CARRIED_DISTANCE * radius else 0.0
    length, away = 2 * float(np.linalg.norm(centre)), float(np.linalg.norm(pulled)) / speed**2
    fast = (speed / critical_speed(scene, body, spin, stiffened=False)) ** 2
    known = 1 + OF_SPIN * fast
    return 1 - float(np.sqrt(known / (known + OF_HUB * away / length * fast))) if length > 0 else 0.0


OF_SPEED, OF_TENSION = 0.58, 0.21
OF_CHORDS, ACROSS, WITHIN = 1 / 8, 0.57, 0.083


@check("missing-stiffening", (SPIN,))
def missing_stiffening(solution: Solution) -> Iterator[Caution]:
    """Centrifugal stiffening inside of a body, or of its parts, is not in these numbers.

    Limit: 0.5 to 1 % of the lowest frequency; a doubt from 2.5 to 5 % on.
    Fix: `spin_stiffening = true`, or the number of `frames` that is told.
    """
    omega = np.real(angular_velocity(solution.system, solution.q[-1], solution.v[-1]))
    speed = float(np.sqrt(omega @ omega))
    parts = {name: _part(solution, name, speed) for name in _flexible(solution)}
    yield from _of_cut_bodies(solution)
    worst = max(parts, key=lambda name: parts[name], default=None)
    if worst is None or not parts[worst] > REMARK_PART:
        return
    part = parts[worst]
    lowers = f"by about {part:.1%}" if part < 1 else "by any amount"
    text = (
        f"centrifugal stiffening inside of {worst!r} is not in these numbers, which lowers the lowest frequency across the plane of the "
        f"spin {lowers}, and those in this plane by more. Fix: spin_stiffening = true in its table, with a reduced model that was built "
        "for it; or more bodies in a row, which stiffen at the joints between them: with twice as many a quarter of this is left."
    )
    if flexible_body(solution.system.scene, worst).spin_stiffening:
        text = told(worst, part)
    yield missing_stiffening.caution(text, doubt=part > DOUBT_PART)


def _of_cut_bodies(solution: Solution) -> Iterator[Caution]:
    scene = solution.system.scene
    for name, body in ((name, body) for name, body in scene.bodies.items() if isinstance(body, CutBody)):
        across, within = lacking(solution, name, body)
        spatial, frames = len(scene.space.axes) > 2, len(body.cuts) - 1  # in the plane nothing vibrates across it
        worst = max(across if spatial else 0.0, within / 2)
        if worst > REMARK_PART:
            lowest = f"the lowest frequency across the plane of the spin by about {across:.1%}, and that in this plane"
            enough = int(np.ceil(frames * np.sqrt(worst / REMARK_PART)))
            yield missing_stiffening.caution(
                f"centrifugal stiffening inside of the parts of {name!r} is not in these numbers, which lowers "
                f"{lowest if spatial else 'the lowest frequency'} by about {within:.1%}. Linear FFRF stiffens a body at the cuts "
                f"between its parts. Fix: frames = {enough} leaves about {2 * REMARK_PART:.0%}, and cuts that are closer where "
                "it bends most "
                "leave less.",
                doubt=worst > DOUBT_PART,
            )


def lacking(solution: Solution, name: str, body: CutBody) -> tuple[float, float]:
    """Parts by which the lowest frequencies of a cut body across the plane of the spin and in this plane are too low."""
    scene = solution.system.scene
    forces: dict[str, dict[str, float]] = {part: {} for part in body.parts(name)}
    of_joints = wrenches_of_joints(solution).at(0)[:, 0, : scene.dimension]
    for force, joint in zip(of_joints, scene.joints.values(), strict=True):
        for grip, point in joint.grips if isinstance(joint, Joint) else ():
            part = grip if grip in forces else scene.piece(grip, point) if grip == name else ""
            if part in forces:
                forces[part][point] = max(forces[part].get(point, 0.0), float(np.sqrt(force @ force)))
    carried = np.array([max(each.values(), default=0.0) for each in forces.values()])
    free = [len(forces[part]) < 2 for part in (next(iter(forces)), list(forces)[-1])]
    compliances = np.array([bending_compliance(solution, part, Chord(FIRST, LAST)) for part in forces])
    lacks = OF_CHORDS * float(carried * compliances @ _bent(np.array([_length(scene, part) for part in forces]), *free))
    whole = float(carried.max() * np.sqrt(compliances).sum() ** 2)
    return lacks / (1 + ACROSS * whole), lacks / (1 + WITHIN * whole)


def _bent(lengths: np.ndarray, free_at_first: bool, free_at_last: bool) -> np.ndarray:
    """Parts of the energy of bending, of parts with their lengths."""
    if free_at_first and not free_at_last:
        return _bent(lengths[::-1], False, True)[::-1]
    ends = np.append(0.0, np.cumsum(lengths)) / lengths.sum()
    return np.diff(ends) if free_at_first or not free_at_last else -np.diff((1 - ends) ** 5)


def _length(scene: ResolvedScene, part: str) -> float:
    one, other = (np.real(design_point(scene, part).interface(name).here[0][:, 0]) for name in (FIRST, LAST))
    return float(np.linalg.norm(other - one))


def _flexible(solution: Solution) -> list[str]:
    bodies = deforming(solution.system.scene)
    return [name for name, body in bodies.items() if body.turns and not isinstance(body, FramedPart)]


def _part(solution: Solution, body: str, speed: float) -> float:
    scene = solution.system.scene
    gripped: dict[str, float] = {}
    of_joints = wrenches_of_joints(solution).at(0)[:, 0, : scene.dimension]
    for force, joint in zip(of_joints, scene.joints.values(), strict=True):
        for grip, point in joint.grips if isinstance(joint, Joint) else ():
            interface = getattr(scene.interface(point), "interface", None)
            if grip == body and interface in (design_point(scene, body).model.interfaces or {}):
                gripped[interface] = max(gripped.get(interface, 0.0), float(np.sqrt(force @ force)))
    if flexible_body(scene, body).spin_stiffening:
        (spin,) = spins_of(solution, body, np.array([-1]))
        own = off_the_axis(solution, body, spin, -1)
    else:
        own = OF_SPEED * (speed / critical_speed(scene, body)) ** 2
    pairs = [Chord(one, other) for one in gripped for other in gripped if one < other]
    carried = [min(gripped[pair[0]], gripped[pair[1]]) * lateral_compliance(solution, body, pair) for pair in pairs]
    return own + OF_TENSION * max(carried, default=0.0)
