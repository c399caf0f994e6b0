"""About which axis and how fast a scene spins: its driver between a body and the ground says so."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from toolkit.compilation.quantities import STEP
from toolkit.description.run_options import RunOptions
from toolkit.equations.equations import Inputs
from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import quoted
from toolkit.joints.driver import DrivenAngle
from toolkit.solvers.spin.generator import Generator, axis_of_turning, generator
from toolkit.system.system import System

SKEW = 1e-9
"""Sine of the angle, and part of the model size, by which an axis may be off another one."""


STEADY = 1e-6
"""Part of the square of the rate by which it may change: a force of that part of the centrifugal ones."""


class Spin(NamedTuple):
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


def spin_of(system: System, options: RunOptions, inputs: Inputs) -> Spin:
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
    found = Spin(rate * axis, centre, np.real(axis[:, None] * drate + rate * daxis), dcentre, curve)
    _refuse_what_cannot_turn(system, found, name)
    return found


def refuse_acceleration(spin: Spin, inputs: Inputs, options: RunOptions) -> None:
    """Refuse a driver whose rate changes at the end time: bodies then lag behind it, which no steady state shows.

    Raises
    ------
    InputError
        Names the rate and how fast it changes.
    """
    _, rate, change = np.real(inputs.curves[spin.curve])
    if abs(change) > STEADY * rate * rate:
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


def _refuse_what_cannot_turn(system: System, spin: Spin, driver: str) -> None:
    axis, scene = np.real(spin.omega) / spin.speed, system.scene
    for name, body in scene.bodies.items():
        if body.moves and not body.turns:
            raise InputError(
                f'the frame of body {name!r} does not turn, but joint {driver!r} spins the scene. Write frame = "moving".'
            )
        if body.turns == 1 and not body.moves and len(axis) > 1:
            own = axis_of_turning(body)
            away = np.cross(np.real(_origin(system, name)) - np.real(spin.centre), axis)
            if np.abs(np.cross(own, axis)).max() > SKEW or np.abs(away).max() > SKEW * scene.size:
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
