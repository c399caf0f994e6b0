"""Results: everything that a run found out, as plain arrays with the names of their rows and columns."""

from __future__ import annotations

import hashlib
import platform
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from toolkit.components.bodies.model_body import ModelBody
from toolkit.description.description import Description
from toolkit.description.design import Point
from toolkit.description.results_layout import ResultsFileError, SceneRecord
from toolkit.files.scene_reader import scene_from_table
from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.shape_error import shape_error_history
from toolkit.responses.stress import stress_field
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution, flexible_body

if TYPE_CHECKING:
    from toolkit.analyses.sensitivity.run import Run
    from toolkit.foundation.value_types import TomlTable


@dataclass(frozen=True)
class BodyResults:
    """Fields of one flexible body; a derivative's last axis is that of `Results.design`.

    Stress is in the fibre `fibre` (+1 outer, -1 inner) at the end `end` (0 or 1) of element `element`. The shape error is the distance
    of every node to its target; without a target its arrays have no nodes. Of solids in space, whose points belong to no beam, all three
    are -1, and the stress is that of von Mises.
    """

    stress: np.ndarray  # (n_t, n_s)
    dstress: np.ndarray  # (n_t, n_s, n_x)
    element: np.ndarray  # (n_s,)
    end: np.ndarray  # (n_s,)
    fibre: np.ndarray  # (n_s,)
    shape_error: np.ndarray  # (n_t, n_k)
    dshape_error: np.ndarray  # (n_t, n_k, n_x), nan where the distance is zero
    arc_length: np.ndarray  # (n_k,)

    @property
    def stress_points(self) -> list[str]:
        """Names of the columns of `stress`."""
        rows = zip(self.element, self.end, self.fibre, strict=True)
        names = [_stress_point(k, *map(int, row)) for k, row in enumerate(rows)]
        fibres = {
            name: count(1) for name, times in Counter(names).items() if times > 1
        }  # sections in space have several on one side
        return [f"{name} {next(fibres[name])}" if name in fibres else name for name in names]


def _stress_point(column: int, element: int, end: int, fibre: int) -> str:
    if element >= 0:
        return f"element {element}, {'end' if end else 'start'}, {'outer' if fibre > 0 else 'inner'}"
    return f"point {column}"


@dataclass(frozen=True)
class Results:
    """Results of one run, in the units of `units`; `unit` gives the labels.

    Leading d: total derivative by the variables `design`, on the last axis; n_x is zero if none were computed.
    """

    kind: str  # "transient" or "static"
    method: str  # how gradients were computed: "none", "direct", "complex-step", ...
    units: str
    times: np.ndarray  # (n_t,)
    q: np.ndarray  # (n_t, n_q)
    v: np.ndarray
    a: np.ndarray
    multipliers: np.ndarray  # (n_t, n_lam)
    dq: np.ndarray  # (n_t, n_q, n_x)
    dv: np.ndarray
    da: np.ndarray
    dmultipliers: np.ndarray  # (n_t, n_lam, n_x)
    coordinates: list[str]  # names of the columns of q, v, a
    multiplier_names: list[str]
    design: list[str]  # names of the last axis of every derivative
    responses: dict[str, float]
    response_units: dict[str, str]
    gradients: dict[str, dict[str, float]]  # response -> variable -> derivative; empty if none were computed
    bodies: dict[str, BodyResults]
    variables: dict[str, dict[str, Any]]  # variable -> its path in the scene and its value
    run: dict[
        str, Any
    ]  # drift, correction, load_steps, newton_iterations as in `Solution`; wall_primal, wall_sensitivity in s or None
    settings: dict[str, Any]  # solver settings
    scene: SceneRecord
    writers: dict[str, str]  # program -> version
    judged: dict[str, Any] | None = None  # `Verdict.record`; None in files of older versions
    path: Path | None = field(default=None, compare=False)

    @property
    def verdict(self) -> Verdict:
        """Whether the numbers can be trusted, as found when they were stored."""
        if self.judged is None:
            return Verdict(
                (Caution("not-judged", "the results were kept by a version that did not judge them: run the scene again."),)
            )
        return Verdict.from_record(self.judged)

    @property
    def label(self) -> str:
        """Name by which messages speak of the results."""
        return repr(self.path.name) if self.path else "the run"

    def column(self, coordinate: str) -> int:
        """Number of a coordinate, for example of "rotation of body 'body2'"."""
        return self.coordinates.index(coordinate)

    def unit(self, quantity: str) -> str:
        """Label of a quantity, for example of "stress"."""
        from toolkit.foundation.units import unit

        return unit(self.units, quantity)


def table_of(scene: Scene) -> TomlTable:
    """Tables from which `toolkit.files.scene_reader.scene_from_table` makes the same scene, with every number as it is now.

    Raises
    ------
    InputError
        A number is complex: the scene belongs to a complex step.
    """
    table = _plain(scene)
    assert isinstance(table, dict)
    del table["directory"]
    return table


def _plain(value: object) -> object:
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
