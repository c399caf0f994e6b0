"""The cost summary of a scene: coordinates, terms, file groups and derivative blocks, kept and dropped, why, and what they cost."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

import numpy as np

from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions, time_grid
from toolkit.foundation.errors import ToolkitError
from toolkit.report.cost_terms import (
    CostLine,
    bytes_read,
    coordinates,
    derivative_blocks,
    fields,
    files,
    grounded_bodies,
    markers,
    matrix,
    meshes,
    multiplications,
    prepare_everything,
    rows,
    terms,
    with_frames,
)
from toolkit.scene.scene import Scene, forget_models
from toolkit.system.system import System

LEAST_MEASURED_STEPS, LONGEST_MEASURED_STEPS = 16, 0.05
"""Least steps of a measured run, and the time that the dearest one shall take, in s."""

MEASURED_ROUNDS, MEASURING_SECONDS = 9, 3.0
"""Rounds of all runs, as long as they have taken less than this, in s."""


@dataclass(frozen=True)
class Cost:
    """Cost of one way to compile the scene.

    `step_us` is the processor time of a step, None if it was not measured, and then `reason` says why.

    `factorization` and `solution` are multiplications, see `cost_terms.multiplications`.
    """

    what: str
    coordinates: int
    rows: int
    variables: int
    jacobian: int
    factorization: int
    solution: int
    bytes_read: int
    step_us: float | None
    reason: str


def costs(scene: Scene, design: list[str], measured: bool = True) -> list[Cost]:
    """Costs of the motion alone, with gradients, with the frames of grounded bodies, and with everything.

    Parameters
    ----------
    design : names of the variables that gradients are wanted by
    measured : whether to run each of them
    """
    ways: dict[str, Callable[[], System]] = {"motion alone": lambda: prepare(scene)}
    if design:
        ways[f"with gradients by {len(design)} variables"] = lambda: prepare(scene, design)
    if grounded_bodies(scene):
        ways["with coordinates of grounded frames"] = lambda: prepare(with_frames(scene))
    ways["with everything (--keep-all)"] = lambda: prepare_everything(scene)
    found, read = {}, {}
    for what, compiled in ways.items():
        forget_models()
        found[what] = compiled()
        read[what] = bytes_read(found[what])
    times, reason = _step_times(found, scene.solver) if measured else ({}, "not asked for")
    return [_cost(what, system, read[what], times.get(what), reason) for what, system in found.items()]


def _cost(what: str, system: System, read: int, seconds: float | None, reason: str) -> Cost:
    step = None if seconds is None else 1e6 * seconds
    counted = len(system.plan.indices), *multiplications(system.lu_plan)
    return Cost(what, system.n_q, system.n - system.n_q, system.n_x, *counted, read, step, "" if step else reason)


def _step_times(systems: dict[str, System], options: RunOptions) -> tuple[dict[str, float], str]:
    """Time of a step of each system, in s, and why there is none.

    Median difference of a longer and a shorter run, so that the start, which is no step, does not count. A run with error control is
    measured by steps of the greatest length.
    """
    times = time_grid(options)
    if len(times) < 3:
        return {}, "a run of one step is mostly its start"
    found: dict[str, list[float]] = {what: [] for what in systems}
    try:
        for system in systems.values():
            _seconds(system, _until(times, 1, options))
        count = _enough_steps(list(systems.values())[-1], times, options)
        few = max(1, count // 10)
        long, short = (_until(times, n, options) for n in (count, few))
        begun = clock.perf_counter()
        for repeat in range(MEASURED_ROUNDS):
            if repeat and clock.perf_counter() - begun > MEASURING_SECONDS:
                break
            for what, system in systems.items():
                found[what].append((_seconds(system, long) - _seconds(system, short)) / (count - few))
    except ToolkitError as error:
        return {}, str(error)
    medians = {what: median(seconds) for what, seconds in found.items()}
    return {what: seconds for what, seconds in medians.items() if seconds > 0}, "its runs are too short for the clock"


def _enough_steps(dearest: System, times: np.ndarray, options: RunOptions) -> int:
    """Number of steps that take long enough to be measured, or of all."""
    count = min(LEAST_MEASURED_STEPS, len(times) - 1)
    while count < len(times) - 1 and _seconds(dearest, _until(times, count, options)) < LONGEST_MEASURED_STEPS:
        count = min(2 * count, len(times) - 1)
    return count


def _until(times: np.ndarray, count: int, options: RunOptions) -> RunOptions:
    """Options of a run over the first steps of another."""
    first = tuple(float(time) for time in times[: count + 1])
    return options.model_copy(update={"times": first, "end_time": first[-1], "local_error": None})


def _seconds(system: System, options: RunOptions) -> float:
    """Processor time of a run in s.

    Other programs on the machine slow a run down, but do not make it work more.
    """
    begun = clock.process_time()
    simulate(system, options)
    return clock.process_time() - begun


def cost_summary(scene: Scene, design: list[str], keep_all: bool = False, measured: bool = True) -> dict[str, Any]:
    """Sections of lines, the errors of meshes, then the costs; as in `ffrf inspect SCENE --json`.

    Parameters
    ----------
    design : names of the variables that gradients are wanted by
    keep_all : whether the lines are those of the scene with everything put back; the costs are of both
    measured : whether to measure the time of a step too, by running the scene

    Raises
    ------
    InputError, ModelFileError
        The scene cannot be compiled.
    """
    forget_models()
    system = prepare_everything(scene) if keep_all else prepare(scene, design)
    sections: dict[str, list[CostLine]] = {
        "coordinates": coordinates(system),
        "constraint rows": rows(system),
        "terms (entries)": terms(system),
        "derivative blocks (rows of the residual)": derivative_blocks(system, scene),
        "fields (points)": fields(system),
        "markers": markers(system),
        "matrix (entries)": matrix(system),
        **{f"bytes of {path}": lines for path, lines in files(system).items()},
    }
    found: dict[str, Any] = {name: [line._asdict() for line in lines] for name, lines in sections.items()}
    return {**found, "meshes": meshes(system), "cost": [asdict(each) for each in costs(scene, design, measured)]}
