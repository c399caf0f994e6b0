"""Velocities that a scene writes for the start, and their refusal where the joints do not allow them."""

from __future__ import annotations

import numpy as np

from toolkit.bodies.body import Body
from toolkit.bodies.model_body import ModelBody
from toolkit.compilation.quantities import STEP
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.system.system import System

ELASTIC = "elastic_velocity"
"""Key of a flexible body's table that writes velocities of its points in its own axes."""
HOLDS = 1e-6
"""Part of the fastest velocity of the start by which a written one may miss what the joints allow: it was written with seven digits."""
DERIVATIVE_HOLDS = 1e-8
"""Part of the fastest derivative by a design variable by which one may miss what the joints allow; it has no written digits."""
ALIKE = 0.9
"""Part of the largest miss from which the first one is named, so that no round-off decides."""


def written_velocities(system: System) -> dict[int, str]:
    """Coordinates whose velocity the scene writes -> path that says so, rotations of a body first, and its shape last."""
    bodies, first = system.scene.bodies.items(), system.numbering.first
    found = {first[name] + k: f"bodies.{name}.{key}" for name, body in bodies for k, key in body.written_velocities().items()}
    return found | {i: f"bodies.{name}.{ELASTIC}" for name, body in bodies if writes_shape(body) for i in _elastic(system, name)}


def writes_shape(body: Body) -> bool:
    """Whether velocities of points of a flexible body are written, and with them those of all its elastic coordinates."""
    return isinstance(body, ModelBody) and bool(body.deflected[ELASTIC])


def _elastic(system: System, name: str) -> range:
    """Numbers of a body's elastic coordinates."""
    body, first = system.scene.bodies[name], system.numbering.first[name]
    return range(first + body.frame_size, first + len(body.coordinate_names(system.scene)))


def refuse_own_velocities(system: System, given: np.ndarray, found: np.ndarray) -> None:
    """Refuse given velocities (n,) of all coordinates that the joints do not allow, where `found` are the nearest that they do.

    Raises
    ------
    InputError
        Names the coordinate with both velocities.
    """
    missed, fastest = _missed(system, np.real(given), np.real(found))
    if missed.max(initial=0) > HOLDS * fastest:
        i = int(np.argmax(missed >= ALIKE * missed.max()))
        raise InputError(
            f"the velocities that were given as a start contradict the joints: that of {system.numbering.names[i]} is "
            f"{np.real(given[i]):.9g}, and {np.real(found[i]):.9g} in the nearest motion that the joints allow. Give velocities that fit, "
            "or none."
        )


def refuse_contradictions(system: System, q: np.ndarray, given: np.ndarray, found: np.ndarray, written: dict[int, str]) -> None:
    """Refuse velocities (n,) of written coordinates that did not come out as they were given; and, in a complex step, their derivatives.

    Raises
    ------
    InputError
        Names the path with both velocities.
    """
    missed, fastest = _missed(system, np.real(given), np.real(found))
    wrong = [i for i in written if missed[i] > HOLDS * fastest]
    if wrong:
        first = next(i for i in wrong if missed[i] >= ALIKE * missed[wrong].max())
        path, wish, allowed = _in_numbers(system, first, written[first], q, given, found)
        raise InputError(
            f"{path} is written as {wish} at the start, but the joints, with what else is written, allow {allowed}. Write what fits, or "
            f"leave velocities out: those that are not written are found by the joints.{_advice(system, path)}"
        )
    changed, largest = _missed(system, np.imag(given), np.imag(found))
    moved = [i for i in written if changed[i] > DERIVATIVE_HOLDS * max(largest, STEP * fastest)]
    if moved:
        raise InputError(_contradiction(system, "the design variable of the complex step", written[moved[0]]))


def refuse_variables_that_contradict(
    system: System, found: np.ndarray, dgiven: np.ndarray, dfound: np.ndarray, written: dict[int, str]
) -> None:
    """Refuse design variables that move what the joints imply, but not what is written.

    Raises
    ------
    InputError
        Names the variable and the path.
    """
    weights, n_q = system.weights[: system.n_q, None], system.n_q
    fastest = float((weights[:, 0] * np.abs(np.real(found))[:n_q]).max(initial=0))
    sizes = np.array([abs(x.value) or (system.scene.size if x.path.startswith("points.") else 1.0) for x in system.design])
    missed = weights * np.abs(dfound - dgiven)[:n_q]
    largest = np.maximum(fastest / sizes, (weights * np.abs(dfound)[:n_q]).max(axis=0, initial=0))
    for i, path in written.items():
        for x in np.flatnonzero(missed[i] > DERIVATIVE_HOLDS * largest):
            raise InputError(_contradiction(system, f"design variable {system.design.names[x]!r}", path))


def _contradiction(system: System, variable: str, path: str) -> str:
    key = ".".join(path.split(".")[:3])
    return (
        f"{variable} would make {path} contradict the joints at the start: more velocities are written than the joints leave free, so that "
        f"there is no derivative by it. Leave {key} or another velocity out: those that are not written are found by the joints."
        f"{_advice(system, path)}"
    )


def _missed(system: System, given: np.ndarray, found: np.ndarray) -> tuple[np.ndarray, float]:
    """Differences (n_q,) of velocities from given ones, and the fastest of all, in parts of the model size (or rad) per time."""
    weights, n_q = system.weights[: system.n_q], system.n_q
    fastest = (weights * np.maximum(np.abs(found), np.abs(given))[:n_q]).max(initial=0)
    return weights * np.abs(found - given)[:n_q], float(fastest)


def _in_numbers(system: System, i: int, path: str, q: np.ndarray, given: np.ndarray, found: np.ndarray) -> tuple[str, str, str]:
    """Path, written and found number of a coordinate's velocity, in the numbers that a scene writes."""
    name = path.split(".")[1]
    body, first = system.scene.bodies[name], system.numbering.first[name]
    at = slice(first, first + len(body.coordinate_names(system.scene)))
    if i in _elastic(system, name):
        length, label = float(body.coordinate_lengths(system.scene)[i - first]), f"{unit(system.scene.units, 'length')}/s"
        of = f"{label} of {system.numbering.names[i]} (RMS of its points)"
        wish, allowed = (f"{_listed(length * v[i : i + 1])} {of}" for v in (given, found))
        return path, wish, allowed
    turns = i >= first + body.frame_size - body.turns
    label = "rad/s" if turns else f"{unit(system.scene.units, 'length')}/s"
    pair = (body.frame_motion(q[at], v[at])["angular_velocity"] if turns else v[i : i + 1] for v in (given, found))
    wish, allowed = (f"{_listed(each)} {label}" for each in pair)
    return path, wish, allowed


def _listed(numbers: np.ndarray) -> str:
    """Text of one number, or of several in brackets."""
    shown = ", ".join(f"{x:.9g}" for x in np.real(numbers))
    return shown if len(numbers) == 1 else f"[{shown}]"


def _advice(system: System, path: str) -> str:
    name, key = path.split(".")[1:3]
    if key == ELASTIC:
        return (
            " What is written of the points of a body decides the motion of all of it: write also those points that joints hold."
        )
    if key == "velocity" and system.scene.bodies[name].turns:
        return f" `angular_velocity` alone, in the place of `velocity`, gives {name!r} a rotation about whatever holds it."
    return ""
