"""What floating frames in number cost: `python -m tests.benchmarks.many_frames` prints two tables for docs/accuracy.md.

The reference wing, and a clamped beam of 1000 elements in the plane that falls under its weight, all its coordinates kept. Times are the
least of interleaved repeats, as the processor counts them; memory is what compiling and running make a process hold at most, as Linux tells
it. Compare ratios, not times of different machines.
"""

from __future__ import annotations

import multiprocessing
import tempfile
import time
from pathlib import Path

import numpy as np

from preprocessing.elements.section import Section
from tests.benchmarks.gradient_cost import run_direct, run_primal
from tests.benchmarks.measure import WING
from tests.models.beam_models import save_beam
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.transient import simulate
from toolkit.files.scene_reader import read_scene
from toolkit.system.system import compile_scene

ELEMENTS = 1000
OF_BEAM, OF_WING = (1, 10, 30, 100, 300, 1000), (1, 2, 4, 8, 16, 30)
REPEATS, STEPS = 7, 20
SECTION = Section(youngs_modulus=2.1e11, density=7800.0, thickness=0.05, width=0.05, damping_stiffness=1e-4)
BEAM = """units = "m-kg-s"
[points]
tip = {{ body = "beam", interface = "tip" }}
[bodies]
beam = {{ type = "flexible", model = "{model}.h5", frame = "grounded", frames = {frames} }}
[loads]
weight = {{ type = "gravity", acceleration = [0.0, -9.81] }}
[design]
width = "bodies.beam.width"
[responses]
fall = {{ type = "displacement", body = "beam", point = "tip", component = "y" }}
[solver]
end_time = {end}
step = 0.01
"""


def wing(step: str) -> dict[int, tuple[float, float]]:
    """Least seconds of a motion and of one with gradients by all variables, each with all responses, over the number of frames."""
    scenes = {n: read_scene(WING, {"bodies.skin.frames": str(n), "solver.step": step}) for n in OF_WING}
    systems = {n: (prepare(scene), prepare(scene, list(scene.design))) for n, scene in scenes.items()}
    times: dict[tuple[int, int], list[float]] = {}
    for _ in range(REPEATS + 1):
        for n, pair in systems.items():
            for which, run in enumerate((run_primal, run_direct)):
                begun = time.process_time()
                run(*pair)
                times.setdefault((n, which), []).append(time.process_time() - begun)
    return {n: (min(times[n, 0][1:]), min(times[n, 1][1:])) for n in OF_WING}  # the first loads compiled code


def beam(folder: str, frames: int) -> tuple[int, int, float, float, float]:
    """Unknowns and Newton's iterations; seconds that compiling takes, and one step; memory that both take at most, in MB."""
    path = Path(folder) / "beam.toml"
    path.write_text(BEAM.format(frames=2, end=0.02, model="short"))
    simulate(compile_scene(read_scene(path)))  # loads compiled code, which takes more memory and time than the beam
    path.write_text(BEAM.format(frames=frames, end=STEPS * 0.01, model="long"))
    scene = read_scene(path)
    scene.model("long.h5")  # so do its checks
    Path("/proc/self/clear_refs").write_text("5")
    before, times, begun = memory("VmRSS"), [], time.process_time()
    system = compile_scene(scene)
    compiled = time.process_time() - begun
    for _ in range(4):
        begun = time.process_time()
        solution = simulate(system)
        times.append(time.process_time() - begun)
    return system.n, solution.newton_iterations, compiled, min(times[1:]) / STEPS, memory("VmHWM") - before


def memory(what: str) -> float:
    """Of this process in MB: what it holds, or the most since that was forgotten; of Linux."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(what))
    return int(line.split()[1]) / 1024


def row(name: str, cells: list[str]) -> str:
    """Of a Markdown table."""
    return f"| {name} | {' | '.join(cells)} |"


def ratios(found: dict[int, tuple[float, float]], step: str) -> list[str]:
    """Rows of one length of steps, in parts of what one frame costs."""
    return [
        row(f"{what}, steps of {step} s", [f"{each[k] / found[1][k]:.1f}" for each in found.values()])
        for k, what in enumerate(("wing: motion", "with five gradients"))
    ]


def main() -> None:
    """Print both tables."""
    print(row("frames", [str(n) for n in OF_WING]) + "\n|---|" + "---|" * len(OF_WING))
    print("\n".join(line for step in ("0.05", "0.001") for line in ratios(wing(step), step)) + "\n")
    with tempfile.TemporaryDirectory() as folder:
        for name, count in (("long", ELEMENTS), ("short", 8)):
            nodes = np.column_stack([np.linspace(0, 100, count + 1), np.zeros(count + 1)])
            save_beam(Path(folder) / f"{name}.h5", nodes, SECTION, {"tip": 100.0})
        with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
            found = [pool.apply(beam, (folder, n)) for n in OF_BEAM]
    print(row(f"beam of {ELEMENTS} elements, frames", [str(n) for n in OF_BEAM]) + "\n|---|" + "---|" * len(OF_BEAM))
    print(row("unknowns", [str(each[0]) for each in found]))
    print(row(f"Newton's iterations in {STEPS} steps", [str(each[1]) for each in found]))
    print(row("one step, ms", [f"{1e3 * each[3]:.1f}" for each in found]))
    print(row("the scene's compilation, s", [f"{each[2]:.1f}" for each in found]))
    print(row("memory, MB", [f"{each[4]:.0f}" for each in found]))


if __name__ == "__main__":
    main()
