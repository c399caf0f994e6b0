"""From a solution, or the result of an analysis, to results as plain arrays."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from toolkit.analyses.run_start import known_start
from toolkit.bodies.model_body import ModelBody
from toolkit.description.description import Description
from toolkit.description.point import Point
from toolkit.foundation.errors import InputError
from toolkit.responses.shape_error import shape_error_history
from toolkit.responses.stress.stress import stress_field
from toolkit.results.results import BodyResults, Results, SceneRecord
from toolkit.scene.scene import Scene
from toolkit.sensitivity.direct import again
from toolkit.sensitivity.evaluation import evaluate_with_gradients
from toolkit.sensitivity.preparation import moving
from toolkit.sensitivity.result import Result, result
from toolkit.system.flexible_bodies import flexible_body
from toolkit.system.solution import Solution


def table_of(scene: Scene) -> dict[str, Any]:
    """Tables from which `toolkit.scene_file.reader.scene_from_table` makes the same scene, with every number as it is now.

    Raises
    ------
    InputError
        A number is complex: the scene belongs to a complex step.
    """
    table = _plain(scene)
    del table["directory"]
    return table


def _plain(value: Any) -> Any:
    if isinstance(value, Point):
        return [_plain(number) for number in (value.x, value.y, value.z) if number is not None]
    if isinstance(value, Description):
        kind = getattr(value, "kind", None)
        return ({"type": kind} if kind else {}) | {name: _plain(item) for name, item in value if item is not None}
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, (tuple, list)):
        return [_plain(item) for item in value]
    if isinstance(value, complex):
        raise InputError("a scene with a complex number cannot be kept in a file. Solve it with real numbers.")
    return value


WRITERS = ("ffrf-toolkit", "numpy", "scipy", "numba", "h5py")


def collect(solved: Result | Solution, text: str = "", changes: Mapping[str, str] | None = None) -> Results:
    """Results of a run.

    Parameters
    ----------
    text : content of the scene's file
    changes : path -> value that replaced the file's

    Raises
    ------
    InputError
        The run was one of a complex step.
    """
    found = solved if isinstance(solved, Result) else _result(solved)
    solution, system = found.solution, found.solution.system
    if not system.compiled:
        raise InputError("a run with complex numbers is a means to a derivative and has no results to keep. Run real numbers.")
    if solution.run_times is not None:
        raise InputError(
            f"the run kept {len(solution.times)} of {len(solution.run_times)} states, because all exceed solver.memory. Raise it, choose "
            "a larger solver.step or a shorter time, or do without a results file."
        )
    n_q, scene = system.n_q, system.scene
    variables = scene.design_variables(list(next(iter(found.gradients.values()), {})) or list(system.design.names))
    return Results(
        kind="transient" if moving(solution) else "static",
        method=found.method,
        units=scene.units,
        times=solution.times,
        **{name: getattr(solution, name) for name in ("q", "v", "a", "multipliers", "dq", "dv", "da", "dmultipliers")},
        coordinates=list(system.numbering.names[:n_q]),
        multiplier_names=list(system.numbering.names[n_q:]),
        design=list(system.design.names),
        responses=found.values,
        response_units=found.units,
        gradients=found.gradients,
        bodies={name: _body(solution, name) for name, body in scene.bodies.items() if isinstance(body, ModelBody)},
        variables={each.name: each.record() for each in variables},
        run={
            "drift": solution.drift,
            "correction": solution.correction,
            "load_steps": solution.load_steps,
            "newton_iterations": solution.newton_iterations,
            "wall_primal": found.wall_primal,
            "wall_sensitivity": found.wall_sensitivity,
        },
        judged=found.verdict.record(),
        settings=(solution.options or scene.solver).model_dump(),
        scene=_record(scene.written.model_copy(update={"solver": solution.options or scene.solver}), text, changes or {}),
        writers={"python": platform.python_version(), **{name: _version(name) for name in WRITERS}},
    )


def _result(solution: Solution) -> Result:
    """Result of a solution with its responses, and with their gradients if it has derivatives."""
    scene, names, wall = solution.system.scene, solution.system.design.names, solution.wall
    values, gradients = evaluate_with_gradients(solution)
    method = "direct" if names else "none"
    repeat = partial(again, solution.system, known=known_start(solution)) if moving(solution) and not solution.own_start else None
    price = wall.get("run"), wall.get("sensitivity", None if names else 0.0)
    return result(scene, solution, values, gradients if names else {}, method, *price, repeat)


def _body(solution: Solution, body: str) -> BodyResults:
    scene = solution.system.scene
    model = scene.model(flexible_body(scene, body).model, "stress", "shape", "surface")
    stress, dstress = stress_field(solution, body)
    error, derror = shape_error_history(solution, body)
    unknown = np.full(stress.shape[1], -1)
    solid = model.surface is not None and len(model.surface.triangles) > 0
    places = (unknown,) * 3
    if model.stress is not None and not solid:
        places = (model.stress.element, model.stress.end, model.stress.fibre)
    arc_length = np.zeros(0) if model.shape is None else model.shape.arc_length
    return BodyResults(stress, dstress, *places, error, derror, arc_length)


def _record(scene: Scene, text: str, changes: Mapping[str, str]) -> SceneRecord:
    models = {
        body.model: hashlib.sha256((scene.directory / body.model).read_bytes()).hexdigest()
        for body in scene.bodies.values()
        if isinstance(body, ModelBody)
    }
    sha256 = hashlib.sha256(text.encode()).hexdigest() if text else ""
    return SceneRecord(table_of(scene), text, sha256, dict(changes), str(scene.directory), models)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed as a package"
