"""What a step costs, and what gradients add: run `python -m tests.benchmarks.measure` from the project's folder.

Times are the least of interleaved repeats in one process, as the processor counts them; compare ratios, not numbers of different machines.
"""

from __future__ import annotations

import time
from pathlib import Path

from tests.benchmarks.chain import chain
from toolkit.analyses.transient import simulate
from toolkit.files.scene_reader import read_scene
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene

WING = Path(__file__).parents[2] / "models" / "morphing_wing" / "scene.toml"
REPEATS = 9


def variables(scene: Scene, count: int) -> tuple[Scene, list[str]]:
    """The scene's own design variables first, then other numbers as far as it has so many, and the scene with names for them."""
    paths = [path for path in scene.available_paths() if not path.startswith(("bodies.skin.position", "bodies.skin.angle"))]
    paths = list(dict.fromkeys([*scene.design.values(), *paths]))
    design = {f"x{k}": path for k, path in enumerate(paths[:count])}
    return scene.model_copy(update={"design": design}), list(design)


def measure(scene: Scene, counts: list[int]) -> None:
    """Print time per step without gradients, and the ratio of the whole run with n_x gradients to the run without."""
    systems = {n_x: compile_scene(*variables(scene, n_x)) for n_x in [0, *counts]}
    times: dict[int, list[float]] = {n_x: [] for n_x in systems}
    for _ in range(REPEATS):
        for n_x, system in systems.items():
            begun = time.process_time()
            solution = simulate(system)
            times[n_x].append(time.process_time() - begun)
    primal = min(times[0])
    print(f"{solution.system.n} unknowns, {solution.steps} steps, {solution.newton_iterations} Newton iterations")
    print(f"  primal {1e3 * primal:.2f} ms, {1e6 * primal / solution.steps:.1f} us per step")
    for n_x in counts:
        real = systems[n_x].n_x
        print(f"  n_x = {real:2d}: {1e3 * min(times[n_x]):.2f} ms, ratio {min(times[n_x]) / primal:.2f}")


if __name__ == "__main__":
    print("morphing wing (reference scene)")
    measure(read_scene(WING), [1, 5, 20, 50])
    fine = read_scene(WING, {"solver.step": "0.001"})
    print("morphing wing, step 1 ms")
    measure(fine, [1, 5, 20, 50])
    for n in (2, 20, 40):
        print(f"chain of {n} rods")
        measure(chain(n, steps=1000), [1, 5, 20, 50])
