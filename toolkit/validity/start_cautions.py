"""Effects of the search for a consistent start: positions that moved, bodies that start deforming."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from toolkit.components.bodies.body import QUATERNION
from toolkit.components.bodies.model_body import ModelBody
from toolkit.description.run_options import RunOptions
from toolkit.foundation.kinematics.orientation import angular_velocity
from toolkit.foundation.units import unit
from toolkit.foundation.value_types import Record
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.scene.scene import Scene
from toolkit.solvers.start.initial_conditions import POSITION_TOLERANCE, moved_by
from toolkit.solvers.start.kept_start import kept_state, other_numbers
from toolkit.solvers.start.rigid_bodies import told
from toolkit.solvers.start.start_velocities import writes_shape
from toolkit.solvers.static.equilibrium import inputs_at
from toolkit.system.solution import Solution, elastic_coordinates
from toolkit.validity.bodies.critical_speed import fastest_spin

Numbers = tuple[float, ...]
RESTING_VELOCITY = 1e-9
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


def _numbers(values: Iterable[float]) -> Numbers:
    return tuple(float(value) for value in values)


def start_record(solution: Solution) -> Record:
    """The start of every body for JSON: name -> quantity -> used and written numbers with their unit."""
    length = unit(solution.system.scene.units, "length")
    units = {"velocity": f"{length}/s", "angular_velocity": "rad/s"}
    record: Record = {}
    for each in start_state(solution):
        frame: Record = {
            key: {"used": list(getattr(each, key)), "written": _listed(getattr(each, f"written_{key}")), "unit": label}
            for key, label in units.items()
            if getattr(each, key) is not None
        }
        deforming = {"used": each.deforming, "written": each.written_deforming, "unit": f"{length}/s"}
        elastic: Record = {} if each.deforming is None else {"deforming": deforming}
        shape: Record = {"deflected": {"used": each.deflected, "unit": length}} if each.deflected else {}
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
            f"{word} {_shown(used, RESTING_VELOCITY * scale)} {label}"
            + ("" if written is None else f" (written {_shown(written)})")
            for word, used, written, scale, label in (
                ("velocity", each.velocity, each.written_velocity, fastest * size, f"{length}/s"),
                ("angular velocity", each.angular_velocity, each.written_angular_velocity, fastest, "rad/s"),
            )
            if used is not None and (max(map(abs, used)) > RESTING_VELOCITY * scale or written is not None)
        ]
        if each.deforming is not None and each.deforming > RESTING_VELOCITY * fastest * size:
            parts.append(f"deforming with {each.deforming:.6g} {length}/s")
        if each.deflected is not None and each.deflected > RESTING_VELOCITY * size:
            parts.append(f"a deflection of {each.deflected:.6g} {length} (RMS of its points)")
        if parts:
            lines.append(f"{each.body} starts with {', '.join(parts)}.")
    return lines if len(lines) <= most else [*lines[:most], f"{len(lines) - most} more bodies start in motion."]


def _shown(numbers: Numbers, rests: float = 0.0) -> str:
    shown = ", ".join(f"{number if abs(number) > rests else 0.0:.6g}" for number in numbers)
    return shown if len(numbers) == 1 else f"[{shown}]"


WRITTEN_POSITION_TOLERANCE = 1e-9
"""Move of a body, relative to the model size or in rad, below which its position is as good as written with nine digits."""


def _written_shapes(scene: Scene) -> dict[str, ModelBody]:
    """Flexible bodies with a written deflection at the start, by name."""
    return {name: body for name, body in scene.bodies.items() if isinstance(body, ModelBody) and body.deflected["deflection"]}


@check("assembled")
def bent_otherwise(solution: Solution) -> Iterator[Caution]:
    """Remarks on written deflections that closing the joints has changed."""
    scene = solution.system.scene
    for name, body in _written_shapes(scene).items():
        q_f = np.real(solution.q[0, elastic_coordinates(solution, name)])
        for point, written in body.deflected["deflection"].items():
            found = np.real(body.point(scene, point, name)[0][:, 1:]) @ q_f
            if np.abs(found - np.real(written)).max() > WRITTEN_POSITION_TOLERANCE * scene.size:
                length = unit(scene.units, "length")
                used, wish = (", ".join(f"{x:.6g}" for x in np.real(each)) for each in (found, written))
                yield bent_otherwise.caution(
                    f"solver.assemble bent {name!r} before the start to close the joints: its deflection at point {point!r} is "
                    f"[{used}] {length} instead of the written [{wish}] {length}.",
                    doubt=False,
                )


@check("deflection-without-effect")
def shapes_without_effect(solution: Solution) -> Iterator[Caution]:
    """A deflection at the start is written of a scene that starts from an equilibrium, which finds its own shape.

    Limit: any.
    Fix: leave it out, or start from the written positions.
    """
    for name in [*_written_shapes(solution.system.scene)][:1]:
        yield shapes_without_effect.caution(
            f"the deflection of {name!r} at the start has no effect: an equilibrium, and a run that starts from one, finds its own shape.",
            doubt=False,
        )


DEFORMING_VELOCITY = 1e-3
"""Velocity of deformation, relative to the fastest of the start, above which there is a remark."""
MOST_NAMED = 3
"""Largest number of bodies that one caution names, those that moved furthest."""


@check("assembled", STATES)
def cautions_of_start(solution: Solution) -> Iterator[Caution]:
    """Cautions about the start of a run over time; of an equilibrium, about closed joints and that it is one at rest."""
    options = solution.options or solution.system.scene.solver
    if len(solution.whole_run) < 2:
        yield from closed_by_statics(solution, options)
        if not solution.spins:
            yield from spinning_at_rest(solution)
        yield from shapes_without_effect(solution)
        return
    if solution.own_start:
        yield from moved_start(solution, solution.start_moved)
        return
    if options.start_file is not None:
        yield from kept_start(solution)
        return
    if options.quasi_static or options.start == "equilibrium":
        yield from shapes_without_effect(solution)
    elif options.start == "given":
        yield from moved_by_assembly(solution)
        yield from bent_otherwise(solution)
    if options.quasi_static:
        yield from velocities_without_effect(solution)
    else:
        yield from deforming_starts(solution)


def moved_bodies(solution: Solution) -> dict[str, tuple[float, float]]:
    """Difference of a run's start from the written positions: body -> (distance of its origin, angle in rad)."""
    given, found, scene = np.real(solution.system.start()[0]), np.real(solution.q[0]), solution.system.scene
    return {name: _move(body, given[at], found[at]) for name, body in scene.bodies.items() for at in [solution.coordinates(name)]}


def _move(body, given: np.ndarray, found: np.ndarray) -> tuple[float, float]:
    size, turns = body.frame_size, body.turns
    shift, at = (found - given)[: size - turns], slice(size - turns, size)
    if turns == QUATERNION:
        angle = 2 * np.arcsin(min(1.0, float(np.linalg.norm(angular_velocity(given[at], found[at]))) / 2))
    else:
        angle = np.abs(found - given)[at].sum()
    return float(np.linalg.norm(shift)), float(angle)


@check("start-of-other-numbers")
def kept_start(solution: Solution) -> Iterator[Caution]:
    """The start is the end of a run with other numbers, and nothing has carried its state over.

    Limit: any.
    Fix: run the first one with these numbers.
    """
    system, end = solution.system, kept_state(solution.system.scene)
    if end is None:
        return
    yield from moved_start(solution, moved_by(system, end.q, solution.q[0]))
    changed = other_numbers(system.scene, end)
    if changed:
        others = f", and {len(changed) - MOST_NAMED} more" if len(changed) > MOST_NAMED else ""
        yield kept_start.caution(
            f"the start is the end of {end.path.name!r}, a run with other numbers: {'; '.join(changed[:MOST_NAMED])}{others}. "
            f"Nothing has carried its state over to these. {kept_start.fix}",
            doubt=False,
        )


@check("start-moved")
def moved_start(solution: Solution, moved: float) -> Iterator[Caution]:
    """The start that was given is off the joints and was moved.

    Limit: `solver.drift_tolerance`.
    Fix: nothing, or smaller drift in the run before.
    """
    allowed = (solution.options or solution.system.scene.solver).drift_tolerance
    if moved > allowed:
        yield moved_start.caution(
            f"the given start is off the joints at t = 0. It was moved by {moved:.1e} of the model size (or rad), more than "
            f"solver.drift_tolerance ({allowed:.1e}), so this run does not go on exactly where the other one ended.",
            doubt=False,
        )


@check("assembled")
def moved_by_assembly(solution: Solution) -> Iterator[Caution]:
    """Joints did not close in the written positions or deflections, and closing them moved bodies.

    Limit: 1e-9 of the model size (or rad); in statics its own tolerance of positions.
    Fix: nothing, or write the positions that are told.
    """
    size, label = solution.system.scene.size, unit(solution.system.scene.units, "length")
    moves = {
        name: move for name, move in moved_bodies(solution).items() if max(move[0] / size, move[1]) > WRITTEN_POSITION_TOLERANCE
    }
    if moves:
        furthest = sorted(moves, key=lambda name: -max(moves[name][0] / size, moves[name][1]))[:MOST_NAMED]
        told = "; ".join(f"{name!r} by {moves[name][0]:.3g} {label} and {moves[name][1]:.3g} rad" for name in furthest)
        others = f"; and {len(moves) - len(furthest)} more" if len(moves) > len(furthest) else ""
        yield moved_by_assembly.caution(
            f"solver.assemble moved bodies before the start to close the joints: {told}{others}. The run is that of the moved scene.",
            doubt=False,
        )


@check("assembled")
def closed_by_statics(solution: Solution, options: RunOptions) -> Iterator[Caution]:
    """Joints that statics closed."""
    system = solution.system
    q = system.undeformed()[0]
    zero = np.zeros_like(q)
    gaps = np.real(system.evaluate(inputs_at(system, options, 0.0), q, zero, zero).applied)[system.n_q :]
    sizes = np.abs(gaps) * system.weights[system.n_q :]
    if sizes.max(initial=0) > POSITION_TOLERANCE:
        row = int(np.argmax(sizes))
        yield closed_by_statics.caution(
            f"statics closed joints that are open in the written positions: {system.numbering.names[system.n_q + row]} by "
            f"{told(system, system.n_q + row, gaps[row]).lstrip('-')}, {sizes[row]:.1e} of the model size (or rad).",
            doubt=False,
        )


@check("at-rest")
def spinning_at_rest(solution: Solution) -> Iterator[Caution]:
    """An equilibrium at rest of a scene that spins: centrifugal forces are not in it.

    Limit: any spin by a driver or a velocity.
    Fix: `solver.equilibrium = "spinning"` where a driver spins the scene as a whole, or a motion.
    """
    found = fastest_spin(solution)
    if found is not None:
        body, spin, when = found
        yield spinning_at_rest.caution(
            f"this equilibrium is one at rest, but the scene spins: {body!r} with {spin:.4g} rad/s {when}. Centrifugal forces are not in "
            f"it. {spinning_at_rest.fix}",
            doubt=False,
        )


@check("velocity-without-inertia")
def velocities_without_effect(solution: Solution) -> Iterator[Caution]:
    """A velocity at the start has no effect, because `solver.quasi_static` leaves out inertia.

    Limit: any.
    Fix: leave it out, or leave out `solver.quasi_static`.
    """
    scene = solution.system.scene
    written = [name for name, body in scene.bodies.items() if body.written_velocities() or writes_shape(body)]
    moving = [name for name in written if np.any(scene.bodies[name].initial_state(scene)[1])]
    if moving:
        yield velocities_without_effect.caution(
            f"the velocity of {moving[0]!r} at the start has no effect: solver.quasi_static leaves out inertia.",
            doubt=False,
        )


@check("starts-deforming")
def deforming_starts(solution: Solution) -> Iterator[Caution]:
    """Joints and written velocities leave no motion in which a body keeps its shape: it begins to vibrate.

    Limit: 1e-3 of the fastest velocity of the start.
    Fix: velocities that fit, or drivers that begin smoothly.
    """
    label = unit(solution.system.scene.units, "length")
    fastest = float((solution.system.weights[: solution.system.n_q] * np.abs(np.real(solution.v[0]))).max(initial=0))
    for each in start_state(solution):
        if (
            each.written_deforming is None
            and each.deforming
            and each.deforming > DEFORMING_VELOCITY * fastest * solution.system.scene.size
        ):
            yield deforming_starts.caution(
                f"{each.body!r} starts deforming with {each.deforming:.3g} {label}/s: the joints and the written velocities leave no "
                f"motion in which it keeps its shape. It begins to vibrate. {deforming_starts.fix}",
                doubt=False,
            )
