"""What the preprocessing of solids costs: run `python -m tests.benchmarks.solid_preprocessing [UNKNOWNS]` from the project's folder.

Boxes of 1 x 0.2 x 0.2 m of tetrahedra with 10 nodes and of hexahedra with 20, up to a number of unknowns (10 000 if none is given; up to
100 000 it takes some minutes, and 3 GB with pypardiso): 6 static shapes, 20 modes, a pressure surface and all derivatives. Each runs in a
process of its own, so that the peak of the memory is its own; compare ratios, not numbers of different machines or days.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path

SIZES = {
    "tetra10": (3, 4, 6, 8, 9),
    "hexahedron20": (3, 4, 6, 8, 11),
}
"""Cells across; there are five times as many along: 2 600 to 99 000 unknowns."""
TOP = "\n[pressure_surfaces.top]\nbox = [0.0, -0.1, 0.1, 1.0, 0.1, 0.1]\n"


def unknowns(kind: str, across: int) -> int:
    """Of a box with so many cells across: three for each node, of those on edges, and of tetrahedra in the faces and cells too."""
    a, b, c = (5 * across, across, across)
    if kind == "tetra10":
        return 3 * (2 * a + 1) * (2 * b + 1) * (2 * c + 1)
    corners = (a + 1) * (b + 1) * (c + 1)
    return 3 * (corners + a * (b + 1) * (c + 1) + (a + 1) * b * (c + 1) + (a + 1) * (b + 1) * c)


def measure(kind: str, across: int) -> None:
    """Build one body and print what it cost."""
    from preprocessing import build
    from tests.models.solid_bodies import box, write_body
    from toolkit.reduced_model.file import save

    with tempfile.TemporaryDirectory() as folder:
        mesh = box(kind, (5 * across, across, across), (1.0, 0.2, 0.2))
        path = write_body(Path(folder), mesh, 'kind = "craig-bampton"\ncount = 20', more=TOP)
        import_module("preprocessing.builders.reduced_body")  # scikit-fem, ahead of the clock
        begun = time.perf_counter()
        model = build(path)
        spent = time.perf_counter() - begun
        save(model, path.with_suffix(".h5"))
        size = path.with_suffix(".h5").stat().st_size / 1e6
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(
        f"{kind:13}{mesh.n:8} unknowns, {model.n_f} coordinates: {spent:7.1f} s, peak {peak:5.2f} GB, file {size:6.1f} MB",
        flush=True,
    )


def main(limit: int) -> None:
    """Every box up to a number of unknowns."""
    for kind, sizes in SIZES.items():
        for across in sizes:
            if unknowns(kind, across) <= limit:
                call = f"from tests.benchmarks.solid_preprocessing import measure; measure({kind!r}, {across})"
                subprocess.run([sys.executable, "-c", call], check=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
