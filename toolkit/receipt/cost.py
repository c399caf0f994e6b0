"""What a scene costs with more and less of it: counted, and measured by interleaved runs of the scene itself."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median

from toolkit.errors import ToolkitError
from toolkit.receipt.everything import grounded_bodies, prepare_everything, with_frames
from toolkit.receipt.files import bytes_read
from toolkit.receipt.unknowns import multiplications
from toolkit.run_options import RunOptions
from toolkit.scene import Scene, forget_models
from toolkit.sensitivity.analysis import prepare, responses_of
from toolkit.solvers.transient import simulate
from toolkit.system import System
from toolkit.time_grid import time_grid

STEPS, REPEATS, PATIENCE = 50, 9, 5.0
"""Most steps of a measured run; rounds of all runs, as long as they have taken less than this, in s."""


@dataclass(frozen=True)
class Cost:
    """What one way to compile the scene costs; `step_us` is the time of a step, None if it was not measured, and then `reason`.

    `factorization` and `solution` are multiplications, see `unknowns.multiplications`.
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
    """The motion alone; with gradients; with the frames of grounded bodies; with everything.

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
        _look(found[what])
        read[what] = bytes_read(found[what])
    times, reason = _step_times(found, scene.solver) if measured else ({}, "not asked for")
    return [_cost(what, system, read[what], times.get(what), reason) for what, system in found.items()]


def _look(system: System) -> None:
    """Let the responses read what they need, as after a run."""
    for response in responses_of(system.scene).values():
        response.check(system.scene)


def _cost(what: str, system: System, read: int, seconds: float | None, reason: str) -> Cost:
    step = None if seconds is None else 1e6 * seconds
    counted = len(system.plan.indices), *multiplications(system.lu_plan)
    return Cost(what, system.n_q, system.n - system.n_q, system.n_x, *counted, read, step, "" if step else reason)


def _step_times(systems: dict[str, System], options: RunOptions) -> tuple[dict[str, float], str]:
    """Time of a step of each system, in s, and why there is none.

    Median of the differences between a longer and a shorter run, so that the start, which is no step, does not count.
    """
    steps = min(STEPS, len(time_grid(options)) - 1)
    few = max(1, steps // 10)
    long, short = (options.model_copy(update={"end_time": n * time_grid(options)[1]}) for n in (steps, few))
    found: dict[str, list[float]] = {what: [] for what in systems}
    try:
        for system in systems.values():
            simulate(system, short)
        begun = clock.perf_counter()
        for repeat in range(REPEATS):
            if repeat and clock.perf_counter() - begun > PATIENCE:
                break
            for what, system in systems.items():
                found[what].append((_seconds(system, long) - _seconds(system, short)) / (steps - few or 1))
    except ToolkitError as error:
        return {}, str(error)
    return {what: median(seconds) for what, seconds in found.items()}, ""


def _seconds(system: System, options: RunOptions) -> float:
    begun = clock.perf_counter()
    simulate(system, options)
    return clock.perf_counter() - begun
