"""From a run to results as plain arrays, and back from these to its scene."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.description.description import Description
from toolkit.description.design import Point
from toolkit.foundation.errors import InputError
from toolkit.kept_run.layout import ResultsFileError, SceneRecord
from toolkit.responses.shape_error import shape_error_history
from toolkit.responses.stress import stress_field
from toolkit.results.results import BodyResults, Results
from toolkit.scene.scene import Scene
from toolkit.scene_file.reader import scene_from_table
from toolkit.system.flexible_bodies import flexible_body
from toolkit.system.solution import Solution

if TYPE_CHECKING:
    from toolkit.sensitivity.run import Run


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


def collect(run: Run, text: str = "", changes: Mapping[str, str] | None = None) -> Results:
    """Results of a run, as a file keeps them.

    Parameters
    ----------
    text : content of the scene's file
    changes : path -> value that replaced the file's

    Raises
    ------
    InputError
        The run was one of a complex step.
    """
    solution, system = run.solution, run.solution.system
    if not system.compiled:
        raise InputError("a run with complex numbers is a means to a derivative and has no results to keep. Run real numbers.")
    if solution.run_times is not None:
        raise InputError(
            f"the run kept {len(solution.times)} of {len(solution.run_times)} states, because all exceed solver.memory. Raise it, choose "
            "a larger solver.step or a shorter time, or do without a results file."
        )
    n_q, scene = system.n_q, system.scene
    variables = scene.design_variables(list(next(iter(run.gradients.values()), {})) or list(system.design.names))
    return Results(
        kind="transient" if len(solution.times) > 1 else "static",
        method=run.method,
        units=scene.units,
        times=solution.times,
        **{name: getattr(solution, name) for name in ("q", "v", "a", "multipliers", "dq", "dv", "da", "dmultipliers")},
        coordinates=list(system.numbering.names[:n_q]),
        multiplier_names=list(system.numbering.names[n_q:]),
        design=list(system.design.names),
        responses=run.values,
        response_units=run.units,
        gradients=run.gradients,
        bodies={name: _body(solution, name) for name, body in scene.bodies.items() if isinstance(body, ModelBody)},
        variables={each.name: each.record() for each in variables},
        run={
            "drift": solution.drift,
            "correction": solution.correction,
            "load_steps": solution.load_steps,
            "newton_iterations": solution.newton_iterations,
            "wall_primal": run.wall_primal,
            "wall_sensitivity": run.wall_sensitivity,
        },
        judged=run.verdict.record(),
        settings=(solution.options or scene.solver).model_dump(),
        scene=_record(scene.written.model_copy(update={"solver": solution.options or scene.solver}), text, changes or {}),
        writers={"python": platform.python_version(), **{name: _version(name) for name in WRITERS}},
    )


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
    return SceneRecord(table_of(scene), sha256, dict(changes), str(scene.directory), models, text)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed as a package"


def restore_scene(results: Results, directory: str | Path | None = None) -> Scene:
    """Scene of stored results, as it was solved.

    Parameters
    ----------
    directory : folder of the reduced models; by default where they were, seen from the results file

    Raises
    ------
    ResultsFileError
        A reduced model is not there, or it is not the one of the run.
    InputError
        The scene has a kind of component that is not known here.
    """
    folder = Path(results.scene.directory if directory is None else directory)
    for model, sha256 in results.scene.models.items():
        _check_model(folder / model, sha256, results)
    return scene_from_table(results.scene.table, folder / (results.path.name if results.path else "results"))


def _check_model(path: Path, sha256: str, results: Results) -> None:
    if not path.is_file():
        raise ResultsFileError(
            f"reduced model {str(path)!r}, which {results.label} was computed with, is not there. Name its folder "
            "(--models, in Python models=), or run the scene again."
        )
    if hashlib.sha256(path.read_bytes()).hexdigest() != sha256:
        raise ResultsFileError(
            f"reduced model {str(path)!r} is not the one that {results.label} was computed with: its hash is another. Run the "
            "scene again, or name the folder of the old model (--models, in Python models=)."
        )
