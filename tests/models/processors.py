"""Other processors on this one: the kernels of the linear algebra that OPENBLAS_CORETYPE chooses, which round differently.

`python -m tests.models.processors` prints the kernels that run here, one a line; `... entries` which entries the models
hold that are built under the kernel of this process, and `... kernel` which one that is.
"""

from __future__ import annotations

import ctypes
import importlib.util
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import numpy as np
import scipy.linalg  # noqa: F401  loads its own copy of OpenBLAS
from numpy._core._multiarray_umath import __cpu_features__ as cpu_features

from preprocessing.builders.build_model import build, read_recipe
from tests.models.solid_bodies import rectangle, write_body
from toolkit.reduced_model.model import ReducedModel

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"
_FILES = (
    "morphing_wing/skin",
    "snap_through/skin",
    "bracket/body",
    "spatial_bracket/body",
    "flexible_slider_crank/frame",
    "spinning_beam/frame",
    "flexible_crank/frame",
)
BUILT = {name: MODELS / name for name in _FILES}
"""Committed models by the files that describe them."""
FRAME = """
units = "m-kg-s"
clamp = ["A"]
nodes = { A = [0, 0, 0], B = [0, 0, 1], C = [0.6, 0, 1], D = [0.6, 0.3, 1.2] }
beams = [
    { from = "A", to = "B", section = "leg" },
    { from = "B", to = "C", section = "arm", orientation = [0, 1, 0] },
    { from = "C", to = "D", section = "leg" },
]
sections.leg = { kind = "tube", diameter = 0.05, wall = 0.004, material = "steel" }
sections.arm = { kind = "rectangle", thickness = 0.01, width = 0.04, material = "steel" }
materials.steel = { youngs_modulus = 2.1e11, poisson_ratio = 0.3, density = 7850.0 }
interface_points = { tip = { node = "D" } }
"""
BASES = {
    "craig-bampton": {"kind": "craig-bampton", "count": 5},
    "free eigenmodes": {"kind": "eigenmodes", "count": 9, "boundary": "free"},
    "static": {"kind": "static"},
}


def kernels() -> list[str]:
    """Three kernels of different vectors that this processor can run; that of Zen is Haswell's."""
    return ["Sandybridge", "Haswell", "SkylakeX" if cpu_features["AVX512F"] else "Nehalem"]


def kernel_in_use() -> set[str]:
    """Names of the kernels of all copies of OpenBLAS in this process."""
    maps = Path("/proc/self/maps").read_text().split("\n")
    libraries = {line.split()[-1] for line in maps if "openblas" in line.lower()}
    found = set()
    for library in map(ctypes.CDLL, sorted(libraries)):
        for name in ("scipy_openblas_get_corename64_", "scipy_openblas_get_corename"):
            if hasattr(library, name):
                getattr(library, name).restype = ctypes.c_char_p
                found.add(getattr(library, name)().decode())
    return found


def under(kernel: str, *arguments: str) -> str:
    """Output of this program under a kernel."""
    environment = {**os.environ, "OPENBLAS_CORETYPE": kernel, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "tests.models.processors", *arguments]
    return subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True).stdout


def built() -> Iterator[tuple[str, ReducedModel]]:
    """The committed models, the wing with computed bases, and a spatial frame and a solid of which nothing is reduced, built now."""
    yield from ((name, build(path.with_suffix(".toml"))) for name, path in BUILT.items())
    yield "rotating_beam/beam", rotating_beam()
    wing = read_recipe(BUILT["morphing_wing/skin"].with_suffix(".toml"))
    yield from ((name, wing.at(keys={"basis": basis}).build()) for name, basis in BASES.items())
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "frame.toml").write_text(FRAME)
        yield "frame", build(Path(folder) / "frame.toml")
        yield "solid", build(write_body(Path(folder), rectangle("quad8", (6, 2), 1.0, 0.2), 'kind = "full"'))


def rotating_beam() -> ReducedModel:
    """The model of models/rotating_beam/build.py."""
    spec = importlib.util.spec_from_file_location("rotating_beam", MODELS / "rotating_beam" / "build.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.model


def entries(model: ReducedModel) -> Iterator[tuple[str, np.ndarray]]:
    """What is stored of every array that is stored by its entries, without values: numbers (n, k) of entries."""
    for item, each in (model.derivatives or {}).items():
        yield f"derivatives/{item}", np.column_stack([each.parameter, each.entry])
    for item, polynomial in (model.affine or {}).items():
        yield f"affine/{item}", np.column_stack([polynomial.term, polynomial.entry])
    if model.basis.startswith("differentiated: identity"):
        yield from ((f"invariants/{item}", np.argwhere(array)) for item, array in vars(model.invariants).items())


if __name__ == "__main__":
    if sys.argv[1:] == ["entries"]:
        print(*sorted(kernel_in_use()))
        for name, model in built():
            for item, numbers in entries(model):
                print(name, item, len(numbers), sha256(numbers.astype(np.int64).tobytes()).hexdigest())
    else:
        print(*kernels(), sep="\n")
