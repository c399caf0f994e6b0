"""Statics against fine paths on random scenes: `python -m tests.benchmarks.static_paths [scenes of each kind [kinds]]`.

Every scene is solved with several numbers of load steps, and by a path of hundreds of steps with formulas of its own
(`tests.models.fine_path`). Both must agree on what happens before the full load, its load factor to 1e-6, and the state. That path is
judged by one with half its steps.
"""

from __future__ import annotations

import sys
import time
from collections import Counter

import numpy as np

from tests.models.fine_path import FinePath, Outcome
from tests.models.random_statics import KINDS, random_scene
from toolkit.analyses.statics import solve_statics
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import BifurcationError, LimitPointError, ToolkitError
from toolkit.scene.scene import Scene
from toolkit.system.system import System, compile_scene

LOAD_STEPS = (10, 1, 3, 50)
LENGTH = 0.004
LOAD, STATE = 1e-6, 1e-6
"""Differences of load factors, and of states in parts of the model size, that are agreement."""


def ours(system: System, load_steps: int) -> tuple[Outcome, float]:
    """What statics says, and how far it moved, in parts of the model size."""
    options = RunOptions(load_steps=load_steps)
    try:
        found = solve_statics(system, options)
    except LimitPointError as error:
        return Outcome("limit", error.load_factor, np.zeros(0), 0), np.nan
    except BifurcationError as error:
        return Outcome("bifurcation", error.load_factor, np.zeros(0), 0), np.nan
    except ToolkitError as error:
        return Outcome(f"end: {error}", np.nan, np.zeros(0), 0), np.nan
    return Outcome("equilibrium", 1.0, found.q[0], found.load_steps), extent(system, found.path.q)


def extent(system: System, q: np.ndarray) -> float:
    """Length of the box that states (n_p, n_q) fill."""
    return float(np.linalg.norm(system.weights[: system.n_q] * np.ptp(q, axis=0)))


def agreement(system: System, found: Outcome, judge: Outcome) -> str:
    """Empty if they agree."""
    if found.what.split(":")[0] != judge.what:
        return f"{found.what} at {found.factor:.8f} instead of {judge.what} at {judge.factor:.8f}"
    if judge.what in ("limit", "bifurcation") and not abs(found.factor - judge.factor) <= LOAD * judge.factor:
        return f"{found.what} at {found.factor:.9f} instead of {judge.factor:.9f}"
    if judge.what == "equilibrium":
        off = np.abs(system.weights[: system.n_q] * (found.q - judge.q)).max()
        return f"state off by {off:.1e}" if off > STATE else ""
    return ""


def judged(
    scene: Scene, length: float = LENGTH, load_steps: tuple[int, ...] = LOAD_STEPS
) -> tuple[Outcome, list[str], dict[str, float]]:
    """The judge's outcome, what does not agree with it, and CPU times."""
    system = compile_scene(scene)
    spent, answers, size = {}, {}, np.nan
    for count in load_steps:
        begun = time.process_time()
        answers[count], moved = ours(system, count)
        spent[f"{count} load steps"] = time.process_time() - begun
        size = np.nanmin([size, moved]) if not np.isnan(moved) else size
    begun = time.process_time()
    judge = FinePath(system, 0.5 if np.isnan(size) else size, length).follow()
    spent["judge"] = time.process_time() - begun
    wrong = [f"{count} load steps: {why}" for count, found in answers.items() if (why := agreement(system, found, judge))]
    return judge, wrong, spent


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    for kind in sys.argv[2:] or KINDS:
        outcomes, errors, times = Counter(), 0, []
        for seed in range(count):
            judge, wrong, spent = judged(random_scene(kind, seed))
            finer, _, _ = judged(random_scene(kind, seed), LENGTH / 2, ()) if seed % 5 == 0 else (judge, [], {})
            if finer.what != judge.what or not abs(finer.factor - judge.factor) < 1e-8:
                wrong.append(f"half the judge's steps: {finer.what} at {finer.factor} instead of {judge.what} at {judge.factor}")
            outcomes[judge.what] += 1
            errors += bool(wrong)
            times.append(spent)
            for each in wrong:
                print(f"  {kind} {seed}: {each}", flush=True)
        median = {name: 1e3 * float(np.median([spent[name] for spent in times])) for name in times[0]}
        print(
            f"{kind}: {dict(outcomes)}, {errors} of {count} disagree; CPU, ms: "
            + ", ".join(f"{n} {t:.0f}" for n, t in median.items()),
            flush=True,
        )
