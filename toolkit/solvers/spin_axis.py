"""About which axis and how fast a scene spins, its motion about that axis, and whether it is the same at every angle.

The motion of a whole scene about an axis, coordinate by coordinate.

A frame that turns with omega about a point c moves its coordinates linearly:

    r' = omega x (r - c),   p' = (0, omega) o p / 2,   theta' = omega,   q_f' = 0        or   v = S q + s,   a = S v

S is constant while the scene turns, whatever its bodies do in their frames. Bodies on a grounded frame stay where they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from toolkit.components.bodies.body import QUATERNION, Body
from toolkit.components.joints.driver import DrivenAngle
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import InputError, quoted
from toolkit.foundation.kinematics.orientation import skew
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.free_motions import free_motions
from toolkit.system.equations import Inputs, Terms
from toolkit.system.quantities import STEP
from toolkit.system.system import System


class Generator(NamedTuple):
    """Matrix S (n_q, n_q) and vector s (n_q,) of a motion v = S q + s of all coordinates."""

    matrix: np.ndarray
    offset: np.ndarray

    def velocity(self, q: np.ndarray) -> np.ndarray:
        """Velocity S q + s at coordinates q (n_q,)."""
        return self.matrix @ q + self.offset

    def acceleration(self, q: np.ndarray) -> np.ndarray:
        """Acceleration S v at coordinates q (n_q,)."""
        return self.matrix @ self.velocity(q)

    def times(self, factor: float) -> Generator:
        """Generator of the same motion at another speed."""
        return Generator(factor * self.matrix, factor * self.offset)

    def turned(self, q: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates after a time, and the matrix that turns their changes and their forces, (n_q, n_q)."""
        n_q = len(q)
        whole = scipy.linalg.expm(time * np.block([[self.matrix, self.offset[:, None]], [np.zeros((1, n_q + 1))]]))
        return whole[:n_q, :n_q] @ q + whole[:n_q, n_q], whole[:n_q, :n_q]


def generator(system: System, omega: np.ndarray, centre: np.ndarray) -> Generator:
    """Generator of an angular velocity (1,), in space (3,) in the axes of space, about a point (d,); real or complex."""
    blocks, offsets = [], []
    for name in system.scene.pieces():
        size = _size(system, name)
        matrix, offset = _of_frame(system.scene.body(name), omega, centre)
        kept = size - len(offset)
        blocks.append(scipy.linalg.block_diag(matrix, np.zeros((kept, kept))) if size else np.zeros((0, 0)))
        offsets.append(np.append(offset, np.zeros(kept)))
    states = np.zeros(len(system.numbering.states))  # of loads, which stay what they are
    blocks.append(np.diag(states))
    offsets.append(states)
    return Generator(scipy.linalg.block_diag(*blocks), np.concatenate(offsets))


def angular_velocity(system: System, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Mean angular velocity (1,), in space (3,), of all frames that can turn, from q, v (n_q,); zero if there are none."""
    rates = []
    for name in system.scene.pieces():
        body, first = system.scene.body(name), system.numbering.first[name]
        at = slice(first, first + body.frame_size)
        rate = body.frame_motion(q[at], v[at]).get("angular_velocity")
        if rate is not None:
            rates.append(rate)
    none = np.zeros(1 if system.scene.space.rotations_add else 3)
    return np.mean(rates, axis=0) if rates else none


def axis_of_turning(body: Body) -> np.ndarray:
    """Unit vector, (1,) in the plane, in space (3,), that one angle turns about."""
    unit = np.zeros(body.frame_size)
    unit[body.moves] = 1.0
    return body.frame_motion(unit, unit)["angular_velocity"]


def _size(system: System, name: str) -> int:
    edges = [*system.numbering.first.values(), system.n_q]
    number = list(system.numbering.first).index(name)
    return edges[number + 1] - edges[number]


def _of_frame(body: Body, omega: np.ndarray, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    across = skew(omega) if len(omega) > 1 else omega[0] * np.array([[0.0, -1.0], [1.0, 0.0]])
    moving = across[: body.moves, : body.moves]
    offset = -(across @ centre)[: body.moves]
    if body.turns == QUATERNION:
        return scipy.linalg.block_diag(moving, left_product(np.append(0 * omega[:1], omega)) / 2), np.append(
            offset, np.zeros(QUATERNION)
        )
    rate = [axis_of_turning(body) @ omega] if body.turns else []
    return scipy.linalg.block_diag(moving, np.zeros((body.turns, body.turns))), np.append(offset, rate)


def left_product(quaternion: np.ndarray) -> np.ndarray:
    """Matrix (4, 4) of the product p -> quaternion o p."""
    a, b, c, d = quaternion
    return np.array([[a, -b, -c, -d], [b, a, -d, c], [c, d, a, -b], [d, -c, b, a]])


AXIS_TOLERANCE = 1e-9
"""Sine of the angle, and part of the model size, by which an axis may be off another one."""


STEADY_RATE = 1e-6
"""Part of the square of the rate by which it may change: a force of that part of the centrifugal ones."""


class SceneSpin(NamedTuple):
    """Spin that the driver asks for: angular velocity omega (1,), in space (3,), and centre (d,).

    Their derivatives (..., n_x) and the driver's time curve stand beside them.
    """

    omega: np.ndarray
    centre: np.ndarray
    domega: np.ndarray
    dcentre: np.ndarray
    curve: int

    @property
    def speed(self) -> float:
        """Angular speed in rad/time."""
        return float(np.sqrt(np.sum(np.real(self.omega) ** 2)))

    def generator(self, system: System) -> Generator:
        """Generator of the motion of all coordinates."""
        return generator(system, self.omega, self.centre)

    def generator_changes(self, system: System) -> list[Generator]:
        """Derivatives of the generator by each design variable."""
        changes = zip(self.domega.T, self.dcentre.T, strict=True)
        stepped = [generator(system, self.omega + 1j * STEP * w, self.centre + 1j * STEP * c) for w, c in changes]
        return [Generator(np.imag(each.matrix) / STEP, np.imag(each.offset) / STEP) for each in stepped]


def spin_of(system: System, options: RunOptions, inputs: Inputs) -> SceneSpin:
    """Spin at the end time, at which `inputs` holds the values of the drivers' curves.

    Raises
    ------
    InputError
        No driver of an angle against the ground turns then, more than one body is driven, or a body cannot turn about that axis.
    """
    rates = {name: inputs.curves[system.plan.joints.curve[j]][1] for j, name in _drivers(system)}
    turning = [(j, name) for j, name in _drivers(system) if np.real(rates[name]) != 0]
    if not turning:
        raise InputError(
            f"nothing says how fast the scene spins: no angle-driver between a body and the ground turns at t = {options.end_time:g}. Add "
            'one, for example curve = { type = "polynomial", coefficients = [0.0, 10.0] } for 10 rad per unit of time, or a later end_time.'
        )
    if len(turning) > 1:
        raise InputError(
            f"{quoted([name for _, name in turning])} drive the scene; a steady spin has one speed and one axis. Keep one of these drivers."
        )
    (j, name), n_x = turning[0], system.n_x
    joint = system.scene.joints[name]
    if "ground" not in joint.bodies:
        raise InputError(
            f"joint {name!r} turns {joint.bodies[0]!r} against {joint.bodies[1]!r}: then the scene does not spin with one speed. A steady "
            "spin is driven by an angle-driver between a body and the ground."
        )
    side = joint.bodies.index("ground")
    sign, marker = (1.0 if side else -1.0), int(system.plan.joints.of[j, side])
    centre, axis = _centre_and_axis(system, system.values.markers[marker].point)
    dcentre, daxis = np.zeros((len(centre), n_x)), np.zeros((len(axis), n_x))
    for x, change in enumerate(system.derivatives):
        if marker in change.markers:
            dcentre[:, x], moved = _centre_and_axis(system, change.markers[marker].point)
            daxis[:, x] = moved if len(moved) > 1 else 0.0
    rate, drate, curve = sign * rates[name], np.zeros(n_x), system.plan.joints.curve[j]
    for pair in np.flatnonzero(system.plan.curve_index == curve):
        drate[system.plan.curve_variable[pair]] += sign * inputs.curves_x[pair, 1]
    found = SceneSpin(rate * axis, centre, np.real(axis[:, None] * drate + rate * daxis), dcentre, curve)
    _refuse_what_cannot_turn(system, found, name)
    return found


def refuse_acceleration(spin: SceneSpin, inputs: Inputs, options: RunOptions) -> None:
    """Refuse a driver whose rate changes at the end time: bodies then lag behind it, which no steady state shows.

    Raises
    ------
    InputError
        Names the rate and how fast it changes.
    """
    _, rate, change = np.real(inputs.curves[spin.curve])
    if abs(change) > STEADY_RATE * rate * rate:
        raise InputError(
            f"the driver turns with {rate:.6g} rad per unit of time at t = {options.end_time:g}, but does not keep that rate: it changes "
            f"by {change:.6g} per unit of time. A steady spin has a constant one: give the driver a curve that ends with one, for example "
            f'{{ type = "polynomial", coefficients = [0.0, {rate:.6g}] }}, or run the motion.'
        )


def _drivers(system: System) -> list[tuple[int, str]]:
    return [(j, name) for j, (name, joint) in enumerate(system.scene.joints.items()) if isinstance(joint, DrivenAngle)]


def _centre_and_axis(system: System, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and third axis of a marker on the ground, from its numbers."""
    return (numbers[:2], np.ones(1)) if system.scene.space.rotations_add else (numbers[:3], numbers[9:12])


def _refuse_what_cannot_turn(system: System, spin: SceneSpin, driver: str) -> None:
    axis, scene = np.real(spin.omega) / spin.speed, system.scene
    for name, body in scene.bodies.items():
        if body.moves and not body.turns:
            raise InputError(
                f'the frame of body {name!r} does not turn, but joint {driver!r} spins the scene. Write frame = "moving".'
            )
        if body.turns == 1 and not body.moves and len(axis) > 1:
            own = axis_of_turning(body)
            away = np.cross(np.real(_origin(system, name)) - np.real(spin.centre), axis)
            if np.abs(np.cross(own, axis)).max() > AXIS_TOLERANCE or np.abs(away).max() > AXIS_TOLERANCE * scene.size:
                raise InputError(
                    f"the frame of body {name!r} turns about an axis of its own, which is not that of joint {driver!r}. "
                    'Write frame = "moving".'
                )


def _origin(system: System, name: str) -> np.ndarray:
    """Fixed origin of a frame that only turns, as its markers know it."""
    for number, marker in enumerate(system.numbering.markers):
        if marker[0] == name:
            return system.values.markers[number].point[12:15]
    return np.zeros(3)


class Linearised(NamedTuple):
    """Residual R at one state and its derivatives, dense.

    They are by q and v (n, n_q), by a and multipliers (n, n), and by the design (n, n_x).
    """

    residual: np.ndarray
    by_q: np.ndarray
    by_v: np.ndarray
    by_acc: np.ndarray
    by_x: np.ndarray

    def spinning(self, motion: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stiffness (n, n) of coordinates and multipliers, damping and mass (n, n_q), for small changes in a spinning frame.

        With S = `motion` a change y of the coordinates in that frame changes q by y, v by y' + S y, a by y'' + 2 S y' + S^2 y:

            M = R_a,   C = R_v + 2 R_a S,   K = R_q + R_v S + R_a S^2
        """
        n_q = motion.shape[0]
        mass, forces = self.by_acc[:, :n_q], self.by_acc[:, n_q:]
        stiffness = self.by_q + self.by_v @ motion + mass @ motion @ motion
        return np.column_stack([stiffness, forces]), self.by_v + 2 * mass @ motion, mass


def linearised(system: System, inputs: Inputs, q: np.ndarray, v: np.ndarray, acc: np.ndarray) -> Linearised:
    """Linearised equations at q, v (n_q,) and acc = [a; lam] (n,)."""
    n_q = system.n_q
    pad = np.zeros(system.n - n_q)
    terms = system.evaluate(inputs, np.append(q, pad), np.append(v, pad), acc, design=True)
    return of_terms(system, terms)


def of_terms(system: System, terms: Terms) -> Linearised:
    """Linearised equations from the terms of the equations, whose rows of constraints are those of positions."""
    n_q = system.n_q
    by_q, by_v, by_acc = (system.dense(each) for each in (terms.I_q + terms.A_q, terms.A_v, terms.I_acc))
    by_acc[n_q:, :n_q] = 0
    for row in system.plan.dropped:
        by_acc[row, row] = 1
    return Linearised(terms.inertial + terms.applied, by_q[:, :n_q], by_v[:, :n_q], by_acc, terms.I_x + terms.A_x)


def moved(motion: Generator, q: np.ndarray, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities (n_q,) and [a; lam] (n,) of coordinates that turn with the scene."""
    return motion.velocity(q), np.concatenate([motion.acceleration(q), multipliers])


def balancing(system: System, transposed_phi_q: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Multipliers (n_lam,) whose joint forces come nearest to balancing forces (n_q,); zero in the place of rows left out."""
    kept = np.ones(system.n - system.n_q, bool)
    kept[[row - system.n_q for row in system.plan.dropped]] = False
    found = np.zeros(len(kept), np.result_type(transposed_phi_q, forces))
    weights = system.weights[: system.n_q]
    found[kept] = np.linalg.lstsq(transposed_phi_q[:, kept] / weights[:, None], -forces / weights)[0]
    return found


ANGLES = (1.0, 2.3)
"""Angles in rad to turn the state by: no multiples of a turn's half, third or quarter."""
FORCE_CHANGE = 1e-7
"""Largest change of forces with the angle, in parts of the largest one or of the centrifugal one at the model size, and of
stiffness, damping and mass in parts of their largest: round-off of stiff bodies is smaller, a rotor that is worth the word is
less round."""


def refuse_what_changes(system: System, inputs: Inputs, motion: Generator, speed: float, q: np.ndarray) -> None:
    """Turn the whole state, and compare forces and linearised equations in the frame that turns with it.

    Raises
    ------
    InputError
        Loads, springs to the ground or bodies that do not turn make a difference; names the coordinate.
    """
    if speed == 0:
        return
    n_q, weights = system.n_q, system.weights[: system.n_q]
    q, real = np.real(q), Generator(np.real(motion.matrix), np.real(motion.offset))
    here, largest = _balanced(system, inputs, real, q)
    free = free_motions(here.by_acc[:n_q, n_q:].T, weights)
    own = _reduced(here, real, free, free)
    inertia = speed**2 * float((np.abs(here.by_acc[:n_q, :n_q]) / np.outer(weights, weights)).max())  # at the model size
    for angle in ANGLES:
        there, turn = real.turned(q, angle / speed)
        state, _ = _balanced(system, inputs, real, there)
        change = turn.T @ state.residual[:n_q] - here.residual[:n_q]
        if (np.abs(change) / weights).max(initial=0) > FORCE_CHANGE * max(inertia, largest):
            _refuse(system, change, angle, "the forces on")
        for one, other, scale in zip(own, _reduced(state, real, turn @ free, turn @ free), _scales(own), strict=True):
            apart = np.abs(other - one)
            if apart.max(initial=0) > FORCE_CHANGE * scale:
                _refuse(system, weights**2 * free[:, int(np.argmax(apart.max(axis=0)))], angle, "the linearised equations of")


def _balanced(system: System, inputs: Inputs, motion: Generator, q: np.ndarray) -> tuple[Linearised, float]:
    """State that turns, with the joint forces that balance it best, and the largest force that they have to balance."""
    n_q, pad = system.n_q, np.zeros(system.n - system.n_q)
    loose = linearised(system, inputs, q, motion.velocity(q), np.append(motion.acceleration(q), pad))
    found = balancing(system, loose.by_acc[:n_q, n_q:], loose.residual[:n_q])
    state = linearised(system, inputs, q, motion.velocity(q), np.append(motion.acceleration(q), found))
    return state, float((np.abs(loose.residual[:n_q]) / system.weights[:n_q]).max())


def _reduced(state: Linearised, motion: Generator, left: np.ndarray, right: np.ndarray) -> list[np.ndarray]:
    n_q = len(left)
    return [left.T @ each[:n_q, :n_q] @ right for each in state.spinning(motion.matrix)]


def _scales(own: list[np.ndarray]) -> list[float]:
    stiffness, damping, mass = (float(np.abs(each).max(initial=0)) for each in own)
    return [stiffness, max(damping, float(np.sqrt(stiffness * mass))), mass]


def _refuse(system: System, change: np.ndarray, angle: float, what: str) -> None:
    name = system.numbering.names[first_largest(np.abs(change) / system.weights[: system.n_q])]
    raise InputError(
        f"the scene is not the same at every angle of its spin: {angle:g} rad further {what} {name} are other ones, as under a weight "
        "across the axis, on springs to the ground off the axis, or where a part that spins without being round is held by one that does "
        "not. Such a scene has no steady state and no modes: simulate it."
    )
