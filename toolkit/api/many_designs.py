"""Functions of a study: its best design, a sweep, and what follows from uncertain numbers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from toolkit.analyses.sensitivity.preparation import Progress
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.studies.executor import Executor
from toolkit.studies.find_uncertainty import find_uncertainty
from toolkit.studies.optimization.optimize import optimized
from toolkit.studies.optimization.optimum import Optimum
from toolkit.studies.problem import problem_of
from toolkit.studies.study_file import Study, naming_study_lines, read_study
from toolkit.studies.sweep import Swept, run_sweep, sweep_problem
from toolkit.studies.uncertain_result import UncertainResult
from toolkit.studies.uncertain_study import uncertain_study


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


def sweep(
    study: Study | str | Path,
    *,
    scene: Scene | None = None,
    output: str | Path | None = None,
    processes: int = 1,
    threads: int = 1,
    dask: str = "",
    progress: Progress | None = None,
) -> Swept:
    """Solve many designs of a study: a grid, scattered ones, or those of a file, as its table [sweep] says.

    Parameters
    ----------
    study
        A study file, what `read_study` has made of one, or a Study made in Python.
    scene
        A scene made in Python, instead of the one that the study names.
    output
        Folder in which all designs are kept. A sweep that was interrupted, even killed, goes on there to the same bits.
    processes
        How many designs are solved at once, each in a process of its own; a script that asks for more than one needs
        `if __name__ == "__main__":`.
    threads
        How many are solved at once in this process instead.
    dask
        Address of a Dask scheduler whose workers solve them instead.
    progress
        Called with the designs solved and the designs in all.

    Returns
    -------
    swept
        `columns` is the table; `values(response)` and `gradients(response)` are arrays, nan where a design failed; `verdict`.

    Raises
    ------
    InputError
        The study, its scene or the designs are invalid; or the folder holds another study, or another run works in it.
    NoDesignError
        Not one design could be solved.
    StudyError
        A process or the cluster ended; what was finished is kept.

    Examples
    --------
    >>> found = ffrf.sweep("study.toml", output="sweep", processes=2)
    >>> found.values("max_stress"), found.gradients("max_stress"), found.verdict
    """
    executor, folder = Executor(processes, threads, dask), made_folder(output)
    with study_of(study) as described:
        return run_sweep(sweep_problem(described, scene), folder, executor, progress)


def uncertainty(
    study: Study | str | Path,
    *,
    scene: Scene | None = None,
    output: str | Path | None = None,
    processes: int = 1,
    threads: int = 1,
    dask: str = "",
    progress: Progress | None = None,
) -> UncertainResult:
    """Find out how sure responses are whose scene has uncertain numbers: those of the study's table [uncertain].

    Parameters
    ----------
    study
        A study file, what `read_study` has made of one, or a Study made in Python.
    scene
        A scene made in Python, instead of the one that the study names.
    output
        Folder in which all designs are kept. What was interrupted, even killed, goes on there to the same bits.
    processes
        How many designs are solved at once, each in a process of its own; a script that asks for more than one needs
        `if __name__ == "__main__":`.
    threads
        How many are solved at once in this process instead.
    dask
        Address of a Dask scheduler whose workers solve them instead.
    progress
        Called with the designs solved and the designs in all.

    Returns
    -------
    found
        `responses[name]` has mean, sigma, quantiles, probabilities beyond limits, and Sobol's indices; `verdict`.

    Raises
    ------
    InputError
        The study or its scene is invalid; the folder holds another study, or another run works in it; or OpenTURNS is not installed.
    NoDesignError
        Not one design could be solved.
    StudyError
        A process or the cluster ended; what was finished is kept.

    Examples
    --------
    >>> found = ffrf.uncertainty("study.toml")
    >>> found.responses["max_stress"].sigma, found.responses["max_stress"].alone, found.verdict
    """
    executor, folder = Executor(processes, threads, dask), made_folder(output)
    with study_of(study) as described:
        return find_uncertainty(uncertain_study(described, scene), folder, executor, progress)


@contextmanager
def study_of(study: Study | str | Path) -> Iterator[Study]:
    """Study, read from its file unless it is one already; errors about keys of the file name their line."""
    described = study if isinstance(study, Study) else read_study(study)
    with naming_study_lines(study):
        yield described


def made_folder(path: str | Path | None) -> Path | None:
    """Folder, which is made unless it is there; None stays None.

    Raises
    ------
    InputError
        It cannot be made.
    """
    folder = None if path is None else Path(path)
    if folder is not None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{str(folder)!r} cannot be made a folder ({error.strerror}). Give another output.") from error
    return folder
