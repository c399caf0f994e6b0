"""Options and keys with values that nobody means."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tests.fuzz.case import Case

MODELS = Path(__file__).parents[2] / "models"
NUMBERS = ["0", "-1", "1", "2", "3", "1000", "1000000", "1000000000", "9223372036854775807", "9223372036854775808", "9" * 5000,
"1e300", "1e-300", "-1e300",
           "1e20", "1e-20", "5e-324", "nan", "inf", "-inf", "1.5", "0x10", "1_000", "", " ", "x", "é", "1e999", "0.0", "-0.0",
           "true", "[1]", "{}", "[[]]",
           "'a'", "1 2", "=", "a=b", "--help"]  # fmt: skip
PATHS = ["thickness", "points.A.x", "points.P", "solver.step", "solver.end_time", "solver.load_steps", "solver.max_iterations",
"solver.tolerance",
         "solver.times", "solver.local_error", "solver.rho_inf", "bodies", "bodies.bob.mass", "loads", "units", "dimension",
         "joints.pivot.type",
         "design", "x", "", ".", "points..x", "points.P.x.y", "responses", "x" * 3000]  # fmt: skip
COMMANDS: dict[str, tuple[str, ...]] = {
    "layers": ("ffrf-preprocess", "skin.toml", "--extrude", "solid.msh", "--layers", "@"),
    "parameter": ("ffrf-preprocess", "skin.toml", "--parameter", "thickness=@"),
    "parameter name": ("ffrf-preprocess", "skin.toml", "--parameter", "@=1.0"),
    "body parameter": ("ffrf-preprocess", "body.toml", "--parameter", "youngs_modulus=@"),
    "chord": ("ffrf", "new", "wing", "new", "--airfoil", "high_speed.dat", "--chord", "@"),
    "set": ("ffrf", "statics", "scene.toml", "--set", "#=@"),
    "set of a motion": ("ffrf", "inspect", "scene.toml", "--no-measure", "--set", "#=@"),
    "variables": ("ffrf", "sensitivity", "scene.toml", "--static", "--variables", "@"),
    "speeds": ("ffrf", "campbell", "scene.toml", "--speeds", "0:1:@"),
    "last speed": ("ffrf", "campbell", "scene.toml", "--speeds", "0:@:2"),
    "modes": ("ffrf", "modes", "scene.toml", "--count", "@"),
    "tolerance": ("ffrf", "certify", "scene.toml", "--no-fresh", "--static", "--tolerance", "@"),
}
KEYS = {
    "skin.toml": [("skin.elements", "skin", "elements"), ("basis.count", "basis", "count"), ("thickness", "section",
    "thickness"), ("width", "section", "width"),
                  ("chord", "airfoil", "chord"), ("clamp_x", "skin", "clamp_x"), ("youngs_modulus", "material", "youngs_modulus"),
                  ("density", "material", "density"), ("frequency", "basis", "frequency"), ("static_error", "basis",
                  "static_error")],
    "body.toml": [("count", "basis", "count"), ("width", "section", "width"), ("scale", "mesh", "scale"), ("poisson",
    "material", "poisson_ratio"),
                  ("density", "material", "density"), ("modulus", "material", "youngs_modulus"), ("frequency", "basis",
                  "frequency"), ("nodes", "clamp", "nodes"),
                  ("box", "clamp", "box"), ("static_error", "basis", "static_error"), ("damping", "damping", "stiffness")],
}  # fmt: skip
"""Keys of the two files: name, table and key."""
WHOLE = ["1000000000", "-1000000000", "0", "1", "1e300", "1e-300", "nan", "[]", "[0]", "[1000000000]", "[0, 1, 1e300, 1e300]",
"[-1e308, -1e308, 1e308, 1e308]",
         "[9223372036854775807]", "5e-324", "1e20", "1e-20", "1e60", "1000000", "100000", "500", "true", '"x"']  # fmt: skip


def cases(rng: np.random.Generator) -> Iterator[Case]:
    """Options and keys in turn."""
    while True:
        name = str(rng.choice(list(COMMANDS)))
        value, path = (str(rng.choice(some)) for some in (NUMBERS, PATHS))
        arguments = tuple(part.replace("@", value).replace("#", path) for part in COMMANDS[name])
        yield Case(f"{name} {path[:30] if '#' in str(COMMANDS[name]) else ''} {value[:30]!r}", arguments, copied)
        for file, keys in KEYS.items():
            changes = [keys[int(k)] for k in rng.integers(len(keys), size=int(rng.integers(1, 3)))]
            yield _with_keys(file, [(table, key, str(rng.choice(WHOLE))) for _, table, key in changes])


def _with_keys(file: str, changes: list[tuple[str, str, str]]) -> Case:
    def write(folder: Path) -> None:
        copied(folder)
        lines = (folder / file).read_text().splitlines()
        for table, key, value in changes:
            header = next((k for k, line in enumerate(lines) if line.strip() == f"[{table}]"), None)
            if header is None:
                lines += [f"[{table}]"]
                header = len(lines) - 1
            end = next((k for k in range(header + 1, len(lines)) if lines[k].startswith("[")), len(lines))
            kept = [line for line in lines[header + 1 : end] if line.partition("=")[0].strip() != key]
            lines[header + 1 : end] = [f"{key} = {value}", *kept]
        (folder / file).write_text("\n".join(lines) + "\n")

    name = ", ".join(f"{table}.{key} = {value}" for table, key, value in changes)
    return Case(f"{file} {name}", ("ffrf-preprocess", file), write)


def copied(folder: Path) -> None:
    """A skin, a body and a scene."""
    for name in ("skin.toml", "high_speed.dat", "low_speed.dat"):
        shutil.copy(MODELS / "morphing_wing" / name, folder / name)
    for name in ("body.toml", "bracket.msh"):
        shutil.copy(MODELS / "bracket" / name, folder / name)
    shutil.copy(MODELS / "pendulum" / "scene.toml", folder / "scene.toml")
