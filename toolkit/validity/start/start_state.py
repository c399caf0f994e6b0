"""The state that a run starts in, body by body: velocities as they are written and as they are used."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.foundation.units import unit
from toolkit.solvers.start.start_velocities import writes_shape
from toolkit.system.solution import Solution

Numbers = tuple[float, ...]
RESTS = 1e-9
"""Part of the fastest velocity of the start below which another is shown as none."""


@dataclass(frozen=True)
class BodyStart:
    """How one body starts; what its frame does not have is None.

    Attributes
    ----------
    body
        Its name.
    velocity
        Of the frame's origin, in length/time.
    angular_velocity
        In rad/time; in space three numbers in the axes of space.
    written_velocity, written_angular_velocity
        What the scene says, None where it leaves it to the joints.
    deforming
        RMS velocity of the body's points by the fastest of its elastic coordinates, in length/time.
    written_deforming
        The same of the velocities that the scene writes of its points, None where it writes none.
    deflected
        RMS displacement of the body's points by the largest of its elastic coordinates, in units of length.
    """

    body: str
    velocity: Numbers | None = None
    angular_velocity: Numbers | None = None
    written_velocity: Numbers | None = None
    written_angular_velocity: Numbers | None = None
    deforming: float | None = None
    written_deforming: float | None = None
    deflected: float | None = None


def writes_start(solution: Solution) -> bool:
    """Whether a run has begun with the velocities that its scene writes."""
    return not solution.own_start and (solution.options or solution.system.scene.solver).start_file is None


def start_state(solution: Solution) -> list[BodyStart]:
    """The start of every body of a run over time; empty for an equilibrium and a run without inertia, which have no velocities."""
    scene, options = solution.system.scene, solution.options or solution.system.scene.solver
    if len(solution.whole_run) < 2 or options.quasi_static:
        return []
    return [_of(solution, name) for name in scene.bodies]


def _of(solution: Solution, name: str) -> BodyStart:
    system = solution.system
    body, at = system.scene.bodies[name], solution.coordinates(name)
    q, v = np.real(solution.q[0, at]), np.real(solution.v[0, at])
    given, wish = (np.real(state[at]) for state in system.start()[:2])
    said = body.written_velocities() if writes_start(solution) else {}
    keys = {"velocity" if k < body.moves else "angular_velocity" for k in said}
    used = {key: _numbers(value) for key, value in body.frame_motion(q, v).items()}
    written = {key: _numbers(value) for key, value in body.frame_motion(given, wish).items() if key in keys}
    return BodyStart(
        name,
        used.get("velocity"),
        used.get("angular_velocity"),
        written.get("velocity"),
        written.get("angular_velocity"),
        _deforming(solution, name, v),
        _deforming(solution, name, wish) if writes_shape(body) and writes_start(solution) else None,
        _deforming(solution, name, q),
    )


def _deforming(solution: Solution, name: str, state: np.ndarray) -> float | None:
    """RMS displacement or velocity of a body's points by the largest of its elastic coordinates."""
    scene = solution.system.scene
    body = scene.bodies[name]
    elastic = state[body.frame_size :]
    lengths = np.real(body.coordinate_lengths(scene))[body.frame_size :]
    return float(np.abs(lengths * elastic).max()) if len(lengths) else None


def _numbers(values: Iterable[Any]) -> Numbers:
    return tuple(float(value) for value in values)


def start_record(solution: Solution) -> dict[str, Any]:
    """The start of every body for JSON: name -> quantity -> used and written numbers with their unit."""
    length = unit(solution.system.scene.units, "length")
    units = {"velocity": f"{length}/s", "angular_velocity": "rad/s"}
    record: dict[str, Any] = {}
    for each in start_state(solution):
        frame = {
            key: {"used": list(getattr(each, key)), "written": _listed(getattr(each, f"written_{key}")), "unit": label}
            for key, label in units.items()
            if getattr(each, key) is not None
        }
        deforming = {"used": each.deforming, "written": each.written_deforming, "unit": f"{length}/s"}
        elastic = {} if each.deforming is None else {"deforming": deforming}
        shape = {"deflected": {"used": each.deflected, "unit": length}} if each.deflected else {}
        record[each.body] = {**frame, **elastic, **shape}
    return record


def _listed(numbers: Numbers | None) -> list[float] | None:
    return None if numbers is None else list(numbers)


def start_lines(solution: Solution, most: int = 8) -> list[str]:
    """The start of the bodies that move, one line each, for people; of many bodies the first ones."""
    system = solution.system
    length, size = unit(system.scene.units, "length"), system.scene.size
    fastest = float((system.weights[: system.n_q] * np.abs(np.real(solution.v[0]))).max(initial=0)) if len(solution.v) else 0.0
    lines = []
    for each in start_state(solution):
        parts = [
            f"{word} {_shown(used, RESTS * scale)} {label}" + ("" if written is None else f" (written {_shown(written)})")
            for word, used, written, scale, label in (
                ("velocity", each.velocity, each.written_velocity, fastest * size, f"{length}/s"),
                ("angular velocity", each.angular_velocity, each.written_angular_velocity, fastest, "rad/s"),
            )
            if used is not None and (max(map(abs, used)) > RESTS * scale or written is not None)
        ]
        if each.deforming is not None and each.deforming > RESTS * fastest * size:
            parts.append(f"deforming with {each.deforming:.6g} {length}/s")
        if each.deflected is not None and each.deflected > RESTS * size:
            parts.append(f"a deflection of {each.deflected:.6g} {length} (RMS of its points)")
        if parts:
            lines.append(f"{each.body} starts with {', '.join(parts)}.")
    return lines if len(lines) <= most else [*lines[:most], f"{len(lines) - most} more bodies start in motion."]


def _shown(numbers: Numbers, rests: float = 0.0) -> str:
    shown = ", ".join(f"{number if abs(number) > rests else 0.0:.6g}" for number in numbers)
    return shown if len(numbers) == 1 else f"[{shown}]"
