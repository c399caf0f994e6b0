"""From results back to the scene and its solution, without solving anything."""

from __future__ import annotations

import hashlib
from pathlib import Path

from toolkit.kept_run.layout import STATES, ResultsFileError
from toolkit.results.results import Results
from toolkit.scene.scene import Scene
from toolkit.scene_file.reader import scene_from_table
from toolkit.sensitivity.preparation import prepare
from toolkit.system.solution import Solution


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


def restore_solution(results: Results, directory: str | Path | None = None) -> Solution:
    """Solution of stored results, with its compiled scene, as if just solved. Parameters and errors as `restore_scene`."""
    system = prepare(restore_scene(results, directory), results.design)
    n_q, names = system.n_q, list(system.numbering.names)
    if (names[:n_q], names[n_q:]) != (results.coordinates, results.multiplier_names):
        raise ResultsFileError(
            f"the scene in {_label(results)} has other unknowns than its states; the file is damaged, or this program numbers them "
            "in another way. Run the scene again."
        )
    arrays = {name: getattr(results, name) for name in STATES}
    known = {"run": results.run["wall_primal"], "sensitivity": results.run["wall_sensitivity"]}
    wall = {name: seconds for name, seconds in known.items() if seconds is not None}
    report = {name: results.run[name] for name in ("drift", "correction")}
    counted = {name: int(results.run[name]) for name in ("load_steps", "newton_iterations")}
    return Solution(system, **arrays, **report, **counted, wall=wall, judge=lambda _: results.verdict)  # type: ignore[arg-type]


def _check_model(path: Path, sha256: str, results: Results) -> None:
    if not path.is_file():
        raise ResultsFileError(
            f"reduced model {str(path)!r}, which {_label(results)} was computed with, is not there. Name its folder "
            "(--models, in Python models=), or run the scene again."
        )
    if hashlib.sha256(path.read_bytes()).hexdigest() != sha256:
        raise ResultsFileError(
            f"reduced model {str(path)!r} is not the one that {_label(results)} was computed with: its hash is another. Run the "
            "scene again, or name the folder of the old model (--models, in Python models=)."
        )


def _label(results: Results) -> str:
    return repr(results.path.name) if results.path else "the run"
