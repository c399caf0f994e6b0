"""What gradients cost by both exact methods, and the model that `--method auto` chooses by.

`python -m tests.benchmarks.method_choice` takes a few minutes and prints measured and modelled times per step beside the run itself, by
how much the chosen method is slower than the better one, and the prices of `sensitivity.methods` that fit this machine best.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from statistics import median
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from tests.benchmarks.chain import chain
from tests.benchmarks.measure import WING, variables
from toolkit.analyses.sensitivity.adjoint import adjoint_gradients
from toolkit.analyses.sensitivity.methods import ADJOINT, DIRECT, adjoint_work, direct_work
from toolkit.analyses.sensitivity.preparation import prepare, responses_of
from toolkit.analyses.transient import simulate
from toolkit.files.scene_reader import read_scene
from toolkit.responses.joint_force import JointForce
from toolkit.scene.scene import Scene

REPEATS = 3


class Case(NamedTuple):
    """A measured case: times per step in us beside the run itself, and the work that the model counts."""

    name: str
    n_x: int
    n_r: int
    direct: float
    adjoint: float
    direct_work: np.ndarray
    adjoint_work: np.ndarray


def cases() -> Iterator[Case]:
    """Wing and chains, few and many variables and responses."""
    wing = read_scene(WING, {"solver.step": "0.002"})
    for n_x in (1, 5, 20, 50, 200):
        for n_r in (1, 5, 20):
            scene, names = variables(wing, n_x)
            yield measured("wing", scene, names, n_r, "A" if "A" in wing.joints else next(iter(wing.joints)))
    for n, steps in ((2, 1000), (10, 500), (40, 200), (200, 50)):
        for n_x in (1, 5, 20, 60, 200, 600):
            for n_r in (1, 5, 20):
                if n_x <= 3 * n:
                    scene = chain(n, steps=steps)
                    yield measured(f"chain of {n}", scene, list(scene.design)[:n_x], n_r, "J0")


def measured(name: str, scene: Scene, names: list[str], n_r: int, joint: str) -> Case:
    """One case, its responses all of one cheap kind: other kinds cost the same by either method."""
    responses = {f"force{r}": JointForce(joint=joint, component="xy"[r % 2]) for r in range(n_r)}
    scene = scene.model_copy(update={"responses": responses})
    primal, system = prepare(scene), prepare(scene, names)
    times = np.array([_times(primal, system) for _ in range(REPEATS + 1)])[1:]
    run, direct, adjoint = (median(column) for column in times.T)
    per_step = 1e6 / simulate(primal).steps
    costs = (max(direct - run, 0.0) * per_step, adjoint * per_step)
    return Case(name, len(names), n_r, *costs, direct_work(system, n_r), adjoint_work(system, n_r))


def _times(primal, system) -> tuple[float, float, float]:
    """In s: the run alone, direct with its run, adjoint without."""
    marks = [time.process_time()]
    solution = simulate(primal)
    marks.append(time.process_time())
    changing = simulate(system)
    for response in responses_of(system.scene).values():
        response.evaluate(changing)
    marks.append(time.process_time())
    adjoint_gradients(system, solution)
    marks.append(time.process_time())
    run, direct, adjoint = np.diff(marks)
    return run, direct, adjoint


def fitted(work: list[np.ndarray], times: list[float]) -> np.ndarray:
    """Coefficients, not negative, with the least relative errors."""
    weights = 1 / np.array(times)
    return nnls(np.array(work) * weights[:, None], np.ones(len(times)))[0]


def main() -> None:
    """Measure, fit and print."""
    found = list(cases())
    print("case           n_x  n_r   direct  adjoint us per step   model: direct  adjoint   chosen / better")
    for case in found:
        model = case.direct_work @ DIRECT, case.adjoint_work @ ADJOINT
        chosen = case.adjoint if model[1] < model[0] else case.direct
        regret = chosen / min(case.direct, case.adjoint)
        print(
            f"{case.name:13s} {case.n_x:4d} {case.n_r:4d} {case.direct:8.1f} {case.adjoint:8.1f} {model[0]:22.1f} {model[1]:8.1f} "
            f"{regret:17.2f}"
        )
    print("\nbest coefficients for this machine, us:")
    print("  DIRECT", fitted([case.direct_work for case in found], [max(case.direct, 1e-3) for case in found]))
    print("  ADJOINT", fitted([case.adjoint_work for case in found], [case.adjoint for case in found]))


if __name__ == "__main__":
    main()
