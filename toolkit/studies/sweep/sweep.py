"""A sweep: all designs solved, kept, and judged."""

from __future__ import annotations

from pathlib import Path

from toolkit.foundation.verdict import Verdict
from toolkit.scene.scene import Scene
from toolkit.studies.designs.design_work import WITH, WITHOUT, DesignJob, DesignWork
from toolkit.studies.designs.judged_runs import extremes, margins_cut_off, said_at
from toolkit.studies.designs.solve_designs import failed_designs, refuse_all_failed, solve_designs
from toolkit.studies.engine.executor import SERIAL, Executor, Progress
from toolkit.studies.engine.store import opened_store
from toolkit.studies.study.checked_problem import problem_of_all
from toolkit.studies.study.problem import Problem
from toolkit.studies.study.study_file import Study
from toolkit.studies.sweep.points import points_of
from toolkit.studies.sweep.swept import Swept, refuse_equal_columns

STORE = "sweep.h5"
"""Name of the store in the folder of a sweep."""


def sweep_problem(study: Study, scene: Scene | None = None) -> Problem:
    """A study whose designs are to be swept, checked; raises `InputError` as `problem_of_all`, and of names that are columns already."""
    problem = problem_of_all(study, scene, study.sweep.responses, "sweep.responses")
    refuse_equal_columns(problem)
    return problem


def run_sweep(
    problem: Problem, folder: Path | None = None, executor: Executor = SERIAL, progress: Progress | None = None
) -> Swept:
    """Solve all designs of a sweep.

    Parameters
    ----------
    problem
        The checked study.
    folder
        Where all designs are kept, and found again after an interruption; None keeps nothing.
    executor
        Where they are solved.
    progress
        Called with the designs solved and the designs in all.

    Raises
    ------
    InputError
        The designs are invalid; or the folder holds another study, or another run works in it.
    NoDesignError
        Not one design could be solved.
    StudyError
        A process or the cluster ended; what was finished is kept.
    """
    designs, wanted = points_of(problem), problem.study.sweep.gradients
    asked = [DesignJob(WITH if wanted else WITHOUT, each, wanted) for each in designs]
    with opened_store(None if folder is None else folder / STORE, problem.fingerprint) as store:
        found = solve_designs(DesignWork(problem), asked, store, executor, progress)
    refuse_all_failed(found)
    numbers = {id(each): k + 1 for k, each in reversed(list(enumerate(found)))}
    named = {f"design {numbers[id(each)]}": each for each in extremes(found)}
    margins = margins_cut_off(problem, found, statistics=False, doubt=False)
    cautions = [*failed_designs(found, "; their rows say why.", doubt=False), *margins, *said_at(problem, named)]
    return Swept(
        problem, designs, tuple(found), Verdict.of(cautions), sum(each.seconds for each in {id(e): e for e in found}.values())
    )
