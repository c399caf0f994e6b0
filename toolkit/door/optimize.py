"""The best design of a study, as a function."""

from __future__ import annotations

from pathlib import Path

from toolkit.door.study_and_folder import made_folder, study_of
from toolkit.scene.scene import Scene
from toolkit.sensitivity.clock import Progress
from toolkit.studies.optimization.optimize import optimized
from toolkit.studies.optimization.optimum import Optimum
from toolkit.studies.study.checked_problem import problem_of
from toolkit.studies.study.study_file import Study


def optimize(
    study: Study | str | Path,
    *,
    scene: Scene | None = None,
    output: str | Path | None = None,
    progress: Progress | None = None,
) -> Optimum:
    """Find the best design of a study.

    Parameters
    ----------
    study
        A study file, what `read_study` has made of one, or a Study made in Python.
    scene
        A scene made in Python, instead of the one that the study names.
    output
        Folder in which all designs are kept. A study that was interrupted, even killed, goes on there to the same bits.
    progress
        Called with the designs solved and the most that may be.

    Returns
    -------
    optimum
        Variables, values, multipliers and verdict of the best design; `optimum.success` tells whether it is an optimum, and
        `optimum.check()` raises what is missing.

    Raises
    ------
    InputError
        The study or its scene is invalid; or the folder holds another study, or another run works in it.
    NoOptimumError
        Not one design could be solved.

    Examples
    --------
    >>> found = ffrf.optimize("study.toml", output="optimum")
    >>> found.variables, found.optimality, found.verdict
    """
    folder = made_folder(output)
    with study_of(study) as described:
        return optimized(problem_of(described, scene), folder, progress)
