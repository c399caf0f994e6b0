"""Terms of the equations of motion, counted by the entries of their matrices; rigid bodies are counted together."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import Body
from toolkit.bodies.model_body import ModelBody
from toolkit.cost_summary.line import Line
from toolkit.system.flexible_bodies import deforming
from toolkit.system.system import System


def terms(system: System) -> list[Line]:
    """Lines for mass, stiffness, damping, terms of a rotating frame, weight, and loads."""
    numbers = {name: number for number, name in enumerate(system.scene.all_bodies())}
    flexible = {name: numbers[name] for name in deforming(system.scene)}
    rigid = [numbers[name] for name in rigid_bodies(system)]
    lines = [line for name, number in flexible.items() for line in _flexible(system, number, name)]
    if rigid:
        lines += _rigid(system, rigid)
    falls = bool(np.any(system.scene.gravity != 0))
    lines.append(Line("weight", system.n_q) if falls else Line("weight", 0, 0, "no gravity: zeros, one product each"))
    return [*lines, *(Line(f"load {name}", 1) for name, load in system.scene.loads.items() if load.kind != "gravity")]


def rigid_bodies(system: System) -> list[str]:
    """Names of the bodies that do not deform."""
    return [name for name, body in system.scene.bodies.items() if not isinstance(body, ModelBody)]


def _rigid(system: System, numbers: list[int]) -> list[Line]:
    """Lines for the mass and quadratic velocity of all rigid bodies.

    In the plane their mass is constant, in space only that of those that do not turn.
    """
    lines = [Line("mass of rigid bodies", sum(_filled(system.values.constant[number].mass) for number in numbers))]
    if system.scene.space.constant_rigid_mass:
        return [*lines, Line("quadratic velocity of rigid bodies", 0, 2 * len(numbers), "frame at the centre of mass")]
    turning = [system.values.floating[number] for number in numbers if number in system.values.floating]
    return [*lines, Line("mass and quadratic velocity of rigid bodies, turning", sum(part.entries for part in turning))]


def _flexible(system: System, number: int, name: str) -> list[Line]:
    part, body = system.values.constant[number], system.scene.body(name)
    damped = _filled(part.damping)
    zero = "" if damped else "zero damping: zeros next to the stiffness, one product each"
    elastic = [Line(f"stiffness of {name}", _filled(part.stiffness)), Line(f"damping of {name}", damped, 0, zero)]
    turning = f"mass and quadratic velocity of {name}, turning"
    if number in system.values.floating:
        return [*elastic, Line(turning, frame_entries(system, body))]
    dropped = frame_entries(system, body.model_copy(update={"frame": "moving"}))
    mass = Line(f"mass of {name}, constant", _filled(part.mass))
    return [
        mass,
        *elastic,
        Line(turning, 0, dropped, f"{frame_of(body)} frame, no rotation: the mass matrix is constant, no velocity enters"),
    ]


def frame_of(body: Body) -> str:
    """Word for what the frame of a flexible body does, as the scene writes it; empty for other bodies."""
    return str(getattr(body, "frame", ""))


def frame_entries(system: System, body: Body) -> int:
    """Entries of the invariants of a body with a moving frame."""
    part = body.floating(system.scene)
    return 0 if part is None else part.entries


def _filled(values: np.ndarray) -> int:
    return int(np.count_nonzero(values))
