"""What formulas cost that are compiled once for all processors of a kind: `python -m tests.benchmarks.portable_code`.

numba compiles for the very processor, and code for another one is compiled anew there. Told the name of a level that many share, it
compiles for that: an image of a container, or a folder that machines share, then holds the code of all of them. Beside the time to
compile and the size stand the least times of the wing's motion with gradients, in turn with code for this processor alone, and whether
states and their derivatives are the same to the last bit.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
PORTABLE = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}
"""Processors with AVX2, FMA and BMI: of Intel since 2013, of AMD since 2015."""
ROUNDS = 4
MOTION = """
import hashlib, time
import ffrf
from toolkit.analyses.transient import simulate

model = ffrf.compile(ffrf.read_scene("models/morphing_wing/scene.toml"), variables=["t_w", "M_t", "points.D.x"])
begun = time.process_time()
found = simulate(model._compiled.full)
first = time.process_time() - begun
times = []
for _ in range(150):
    begun = time.process_time()
    found = simulate(model._compiled.full)
    times.append(time.process_time() - begun)
print(first, 1e3 * min(times), hashlib.sha256(found.q.tobytes() + found.dq.tobytes()).hexdigest())
"""


def motion(settings: dict[str, str]) -> tuple[float, float, str]:
    """Processor time of the first motion in s, the least of a later one in ms, and what it has found, of a process of its own."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **settings}
    done = subprocess.run(
        [sys.executable, "-c", MOTION], cwd=ROOT, env=environment, check=True, stdout=subprocess.PIPE, text=True
    )
    first, least, states = done.stdout.split()
    return float(first), float(least), states


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        ways = {"for many processors": {**PORTABLE, "NUMBA_CACHE_DIR": folder}, "for this one": {}}
        compiled = motion(ways["for many processors"])[0]
        size = sum(each.stat().st_size for each in Path(folder).rglob("*.nbc"))
        print(f"compiled in {compiled:.0f} s of CPU, {size / 1e6:.1f} MB")
        found: dict[str, list[tuple[float, float, str]]] = {way: [] for way in ways}
        for _ in range(ROUNDS):
            for way, settings in ways.items():
                found[way].append(motion(settings))
    for way, each in found.items():
        print(f"{way}: {min(least for _, least, _ in each):.2f} ms")
    alike = len({states for each in found.values() for *_, states in each}) == 1
    print("states and derivatives are the same to the last bit" if alike else "states or derivatives differ")
