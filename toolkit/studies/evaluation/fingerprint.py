"""What the numbers of a study follow from, as a hash."""

from __future__ import annotations

from hashlib import sha256
from typing import Any

from toolkit.studies.identity import hashed, program
from toolkit.studies.study.problem import Problem

BUDGET = {"starts", "evaluations"}
"""Options that change how many designs are solved, and no number of any."""
ELSEWHERE = {"search", "directory", "responses", "scene", "uncertain", "sweep", "uncertainty"}
"""Parts of a study that count otherwise, or say only which designs are solved."""


def fingerprint(problem: Problem) -> str:
    """Hash of study, scene, the files that it reads, and the program; more starts or evaluations leave it as it is.

    The order of variables, cases and responses counts: arrays are kept by their places.
    """
    study, scene = problem.study, problem.scene
    search = {key: value for key, value in study.search.model_dump(mode="json").items() if key not in BUDGET}
    rest = study.model_dump(mode="json", exclude=ELSEWHERE)
    order: list[Any] = [
        problem.variables,
        [(name, list(numbers.items())) for name, numbers in problem.cases.items()],
        problem.responses,
    ]
    content = [sha256(path.read_bytes()).hexdigest() for path in scene.read_files()]
    if problem.points is not None:
        options = study.uncertainty.model_dump(mode="json", include={"correlations", "points", "seed"})
        order.append([[(name, each.model_dump(mode="json")) for name, each in study.uncertain.items()], options])
    return hashed(
        rest, search, order, repr(scene.model_copy(update={"directory": study.directory.__class__()})), content, program()
    )
