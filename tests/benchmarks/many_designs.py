"""What one design among many costs: `python -m tests.benchmarks.many_designs` analyses wings with five gradients each.

One after the other, in two threads and in two processes, and one after the other with verdicts; each way is repeated in turn with the
others, and its least time counts. CPU time is that of this process, which for two processes says nothing. Beside them stand the parts of
one design: its plan renewed, its motion with gradients, its responses; and what one costs whose verdict is measured, and not carried from
another design.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import ffrf
from toolkit.analyses.sensitivity.preparation import evaluate_with_gradients
from toolkit.analyses.transient import simulate

WING = Path(__file__).parents[2] / "models" / "morphing_wing" / "scene.toml"
COUNT, REPEATS, JUDGED = 200, 3, 10
WAYS = {
    "one after the other": {"judged": False},
    "two threads": {"threads": 2, "judged": False},
    "two processes": {"processes": 2, "judged": False},
    "one after the other, with verdicts": {},
}


def designs(values: dict[str, float], count: int = COUNT) -> list[dict[str, float]]:
    """Designs that differ in all variables."""
    return [{name: value * (1 + 1e-5 * k) for name, value in values.items()} for k in range(1, count + 1)]


def timed(work: Callable[[], object]) -> tuple[float, float]:
    """Milliseconds of the clock and of the processor."""
    wall, processor = time.perf_counter(), time.process_time()
    work()
    return 1e3 * (time.perf_counter() - wall), 1e3 * (time.process_time() - processor)


def parts(model: ffrf.Model, design: dict[str, float]) -> dict[str, float]:
    """Milliseconds of the processor that the parts of one design take."""
    compiled = model.at(design)._compiled
    renewal = timed(lambda: compiled.full)[1]
    found = []
    motion = timed(lambda: found.append(simulate(compiled.full)))[1]
    return {"renewal": renewal, "motion with gradients": motion, "responses": timed(lambda: evaluate_with_gradients(found[0]))[1]}


if __name__ == "__main__":
    scene = ffrf.read_scene(WING)
    model = ffrf.compile(scene, variables=list(scene.design))
    wanted = designs(model.variables)
    model.map(wanted[:2], gradients=True, judged=False)
    found: dict[str, list[tuple[float, float]]] = {way: [] for way in WAYS}
    for _ in range(REPEATS):
        for way, how in WAYS.items():
            found[way].append(timed(lambda how=how: model.map(wanted, gradients=True, **how)))
    for way, times in found.items():
        wall, processor = (min(each) / len(wanted) for each in zip(*times, strict=True))
        print(f"{way}: {wall:.2f} ms per design, {processor:.2f} ms of CPU in this process")
    judged = min(timed(lambda: model.map(wanted[:JUDGED], gradients=True, judged="each"))[1] for _ in range(REPEATS)) / JUDGED
    print(f"with its verdict measured: {judged:.1f} ms of CPU per design")
    single = [parts(model, design) for design in wanted[:20]]
    for name in single[0]:
        print(f"  {name}: {min(each[name] for each in single):.2f} ms of CPU")
