"""What gradients cost beside the run itself: `python -m tests.benchmarks.gradient_cost` prints a Markdown table for docs/accuracy.md.

(primal + gradient) / primal by direct differentiation and by the adjoint, over the number of design variables. The chain of 200 rods has
600 numbers of its own: both coordinates of every point, and the density of every rod. So has the wing with a skin of 100 elements,
each with its modulus, density, thickness, width and two factors of damping. Times are the least of interleaved repeats in one
process, as the processor counts them, without the compilation of the scene; compare ratios, not times of different machines.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from preprocessing import build
from preprocessing.elements.section import QUANTITIES
from tests.benchmarks.chain import chain
from toolkit.analyses.sensitivity.adjoint import adjoint_gradients
from toolkit.analyses.sensitivity.preparation import prepare, responses_of
from toolkit.analyses.transient import simulate
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.file import save
from toolkit.responses.joint_force import JointForce
from toolkit.responses.motion import Displacement
from toolkit.scene.scene import Scene
from toolkit.system.system import System

WING = Path(__file__).parents[2] / "models" / "morphing_wing"
REPEATS = 5
COUNTS = (1, 5, 20, 60, 600)


def swinging_chain(n: int = 200, steps: int = 100) -> Scene:
    """A chain with two responses: how far its end falls, and the force that holds it."""
    scene = chain(n, steps=steps)
    names = [f"{kind}{k}" for k in range(n) for kind in ("x", "y", "density")]
    responses = {
        "fall": Displacement(body=f"rod{n - 1}", point=f"P{n}", component="y"),
        "force": JointForce(joint="J0", component="magnitude"),
    }
    return scene.model_copy(update={"design": {name: scene.design[name] for name in names}, "responses": responses})


def wing_of_elements(folder: Path, elements: int = 100) -> Scene:
    """The morphing wing, every element of whose skin has numbers of its own; all five responses."""
    for file in WING.iterdir():
        shutil.copy(file, folder / file.name)
    skin = (folder / "skin.toml").read_text()
    for old, new in {
        "elements = 30": f"elements = {elements}\nseparate = [{', '.join(map(repr, QUANTITIES))}]",
        "C = { node = 10 }": f"C = {{ node = {elements // 3} }}",
        "E = { node = 25 }": f"E = {{ node = {5 * elements // 6} }}",
        "G = { node = 30 }": f"G = {{ node = {elements} }}",
    }.items():
        skin = skin.replace(old, new)
    (folder / "skin.toml").write_text(skin)
    save(build(folder / "skin.toml"), folder / "skin.h5")
    text = (folder / "scene.toml").read_text()
    (folder / "scene.toml").write_text(text[: text.index("[design]")] + text[text.index("[responses]") :])
    scene = read_scene(folder / "scene.toml")
    paths = [f"bodies.skin.{quantity}_{k}" for k in range(elements) for quantity in QUANTITIES]
    return scene.model_copy(update={"design": {path: path for path in paths}})


def run_direct(primal: System, system: System) -> None:
    """Gradients along with the motion."""
    solution = simulate(system)
    for response in responses_of(system.scene).values():
        response.evaluate(solution)


def run_adjoint(primal: System, system: System) -> None:
    """The motion, then backwards."""
    adjoint_gradients(system, simulate(primal))


def run_primal(primal: System, system: System) -> None:
    """Values alone."""
    solution = simulate(primal)
    for response in responses_of(primal.scene).values():
        response.value(solution)


METHODS: dict[str, Callable[[System, System], None]] = {"primal": run_primal, "direct": run_direct, "adjoint": run_adjoint}


def costs(scene: Scene, count: int, repeats: int = REPEATS) -> dict[str, float]:
    """Least time of the processor in s of the run alone, and of the run with gradients by each method."""
    primal, system = prepare(scene), prepare(scene, list(scene.design)[:count])
    times: dict[str, list[float]] = {method: [] for method in METHODS}
    for _ in range(repeats + 1):
        for method, run in METHODS.items():
            begun = time.process_time()
            run(primal, system)
            times[method].append(time.process_time() - begun)
    return {method: min(each[1:]) for method, each in times.items()}  # the first loads compiled code


def table(scene: Scene, counts: tuple[int, ...] = COUNTS) -> str:
    """Markdown."""
    found = {count: costs(scene, count) for count in counts}
    head = f"| design variables | {' | '.join(map(str, counts))} |\n|---|{'---|' * len(counts)}"
    ratios = {name: [f"{each[name] / each['primal']:.1f}" for each in found.values()] for name in ("direct", "adjoint")}
    return "\n".join([head, *(f"| {name} | {' | '.join(cells)} |" for name, cells in ratios.items())])


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        print("(primal + gradient) / primal of the wing with 100 elements (24 steps, 5 responses):\n")
        print(table(wing_of_elements(Path(temporary))) + "\n")
    print("(primal + gradient) / primal of a chain of 200 rods (1000 unknowns, 100 steps, 2 responses):\n")
    print(table(swinging_chain()))
