"""What a step costs in space: run `python -m tests.benchmarks.space` from the project's folder.

A chain of flexible beams hanging by ball joints, with 4 to 128 modes for one beam and 1 to 200 beams with 8 modes (models are built first,
`preprocessing`), and chains of 30 to 1000 rigid rods. Times are of CPU, the least of repeats in one process; compare ratios, not numbers of
different machines or days.
"""

from __future__ import annotations

import resource
import tempfile
import time
from pathlib import Path

from preprocessing import build
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import SpatialRod
from toolkit.components.joints.spherical import Spherical
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.description.design import BodyPoint, Point
from toolkit.description.run_options import RunOptions
from toolkit.reduced_model.file import save
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene

REPEATS = 5
STEPS = 200
BEAM = """units = "m-kg-s"
clamp = ["A"]

[nodes]
A = [0, 0, 0]
B = [1, 0, 0]

[[beams]]
from = "A"
to = "B"
elements = {elements}
section = "round"

[sections.round]
kind = "rectangle"
width = 0.02
thickness = 0.013
material = "steel"

[materials.steel]
youngs_modulus = 2.1e11
poisson_ratio = 0.3
density = 7800

[interface_points.tip]
node = "B"

[basis]
kind = "eigenmodes"
count = {modes}
"""


def beam(folder: Path, modes: int) -> str:
    """Name of the reduced model of a beam of 1 m, clamped at its frame, with so many modes."""
    path = folder / f"beam{modes}.toml"
    path.write_text(BEAM.format(elements=max(8, modes // 4 + 2), modes=modes))
    save(build(path), path.with_suffix(".h5"))
    return f"beam{modes}.h5"


def hanging(folder: Path, count: int, modes: int, step: float = 1e-3) -> Scene:
    """Beams one after the other, let go from the horizontal; each hangs by its frame's origin on the tip of the one before."""
    model = beam(folder, modes)
    points: dict[str, Point | BodyPoint] = {"P0": Point(x=0.0, y=0.0, z=0.0)}
    bodies, joints = {}, {}
    for k in range(count):
        bodies[f"beam{k}"] = SpatialFlexible(model=model, frame="moving", position=(float(k), 0.0, 0.0))
        points |= {
            f"root{k}": BodyPoint(body=f"beam{k}", interface="(frame)"),
            f"tip{k}": BodyPoint(body=f"beam{k}", interface="tip"),
        }
        before = ("ground", "P0") if k == 0 else (f"beam{k - 1}", f"tip{k - 1}")
        joints[f"ball{k}"] = Spherical(bodies=(f"beam{k}", before[0]), point=(f"root{k}", before[1]))
    return Scene(
        units="m-kg-s",
        dimension=3,
        points=points,
        bodies=bodies,
        joints=joints,
        loads={"weight": SpatialGravity(acceleration=(0.0, 1.0, -9.81))},
        solver=RunOptions(end_time=STEPS * step, step=step),
        directory=folder,
    )


def rods(count: int, step: float = 1e-3) -> Scene:
    """Rigid rods one after the other between ball joints, let go from the horizontal."""
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={f"P{k}": Point(x=0.1 * k, y=0.0, z=0.0) for k in range(count + 1)},
        bodies={f"rod{k}": SpatialRod(between=(f"P{k}", f"P{k + 1}"), density=7800.0, area=1e-4) for k in range(count)},
        joints={f"ball{k}": Spherical(bodies=(f"rod{k}", f"rod{k - 1}" if k else "ground"), point=f"P{k}") for k in range(count)},
        loads={"weight": SpatialGravity(acceleration=(0.0, 1.0, -9.81))},
        solver=RunOptions(end_time=STEPS * step, step=step),
    )


def measure(scene: Scene, what: str) -> None:
    """Print time per step and per Newton iteration, and how long compiling the scene took."""
    begun = time.process_time()
    system = compile_scene(scene)
    compiled = time.process_time() - begun
    solution, times = simulate(system), []
    for _ in range(REPEATS):
        begun = time.process_time()
        solution = simulate(system)
        times.append(time.process_time() - begun)
    best, memory = min(times), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    print(
        f"  {what}: {system.n} unknowns, {1e6 * best / STEPS:.1f} us per step, {1e6 * best / solution.newton_iterations:.1f} us per Newton "
        f"iteration, scene made ready in {compiled:.2f} s, peak memory of the process {memory:.0f} MB",
        flush=True,
    )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        simulate(compile_scene(hanging(Path(name), 1, 4)))  # compiles
        print("one beam, number of modes")
        for modes in (4, 8, 16, 32, 64, 128):
            measure(hanging(Path(name), 1, modes), f"{modes} modes")
        print("chain of beams with 8 modes, number of beams")
        for count in (1, 2, 5, 10, 20, 50, 100, 200):
            measure(hanging(Path(name), count, 8), f"{count} beams")
        print("chain of rigid rods, number of rods")
        for count in (30, 100, 300, 1000):
            measure(rods(count), f"{count} rods")
