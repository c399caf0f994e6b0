"""How near two processes come to what the machine can do at all: `python -m tests.benchmarks.two_processes`.

Two threads of one core are no two cores: two programs that have nothing to do with each other are slower than each alone, too. So a sweep
with --jobs 2 is judged by two sweeps that run side by side without knowing of each other, and both by one alone; and a bare loop of
numbers says what the core is. Counted are designs by the clock while all that takes part is at work; ways take turns, and of each the
best turn counts, since other work can only slow it down.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import ffrf

ROOT = Path(__file__).parents[2]
STUDY = ROOT / "models" / "morphing_wing" / "study.toml"
COUNT, REPEATS, BEGUN = 64, 4, 16
"""Designs of one process; turns; and designs until when start and loading of compiled formulas, of all processes, do not count any more."""


def stamps(jobs: int, seed: int) -> list[float]:
    """When each design of a sweep was done, in s."""
    study = ffrf.read_study(STUDY)
    sweep = {"points": "sobol", "count": COUNT * jobs, "seed": seed, "responses": ("shape_mse", "stress")}
    described = study.model_copy(update={"constraints": {}, "sweep": type(study.sweep).model_validate(sweep)})
    found: list[float] = []
    ffrf.sweep(described, processes=jobs, progress=lambda done, total: found.append(time.time()))
    return found[1 : len(found) - (jobs - 1)]  # the very last design is solved while the other process has no more


def loop(seconds: float) -> list[float]:
    """When each round of a bare loop of numbers was done."""
    numbers, found, until = np.arange(1.0, 200.0), [], time.time() + seconds
    while time.time() < until:
        total = 0.0
        for _ in range(20_000):
            total += float(numbers[int(total) % 199])
        found.append(time.time())
    return found


def rate(runs: list[list[float]], begun: int) -> float:
    """Designs per second of all runs together, while all are at work."""
    first, last = max(each[begun] for each in runs), min(each[-1] for each in runs)
    return sum(sum(first < t <= last for t in each) for each in runs) / (last - first)


def side_by_side(count: int, *words: str) -> list[list[float]]:
    """What processes of their own found, which began together."""
    command = [sys.executable, "-m", "tests.benchmarks.two_processes", *words]
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / str(k) for k in range(count)]
        running = [subprocess.Popen([*command, str(k), str(file)], cwd=ROOT) for k, file in enumerate(files)]
        for each in running:
            each.wait()
        return [json.loads(file.read_text()) for file in files]


if __name__ == "__main__":
    if len(sys.argv) > 1:
        word, seed, file = sys.argv[1:]
        Path(file).write_text(json.dumps(loop(4.0) if word == "loop" else stamps(2 if word == "jobs" else 1, int(seed))))
        sys.exit()
    ways = {
        "a bare loop, one": (1, "loop", 0),
        "a bare loop, two": (2, "loop", 0),
        "one sweep": (1, "alone", BEGUN),
        "two sweeps side by side": (2, "alone", BEGUN),
        "one sweep, --jobs 2": (1, "jobs", 2 * BEGUN),
    }
    best = dict.fromkeys(ways, 0.0)
    for _ in range(REPEATS):
        for way, (count, word, begun) in ways.items():
            best[way] = max(best[way], rate(side_by_side(count, word), begun))
    for way, found in best.items():
        print(f"{way}: {found:.2f} per second")
    one, two, jobs = (best[way] for way in list(ways)[2:])
    print(f"a bare loop: two are {best['a bare loop, two'] / best['a bare loop, one']:.2f} times one")
    print(f"sweeps: side by side {two / one:.2f} times one, --jobs 2 {jobs / one:.2f}, which is {jobs / two:.0%} of that")
