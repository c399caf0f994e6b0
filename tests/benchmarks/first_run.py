"""What a first command compiles on a fresh machine, in the plane and in space: functions and processor time, stage by stage.

python -m tests.benchmarks.first_run
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[2]
STAGES = """
import sys, time
from toolkit.command_line.rehearsal import rehearse, rehearse_others
from toolkit.foundation.compiled.compile_watch import watched_compilation
from toolkit.files.scene_reader import read_scene

scene = read_scene(sys.argv[1])
for name, work in (
    ("motion", lambda: rehearse(scene, "transient")),
    ("equilibrium", lambda: rehearse(scene, "static")),
    ("adjoint", lambda: rehearse(scene, "transient", True)),
    ("all formulations", lambda: rehearse_others(scene)),
    ("again", lambda: rehearse_others(scene)),
):
    begun = time.process_time()
    with watched_compilation() as watch:
        work()
    print(f"{name:>18}  {watch.functions:4d} functions  {time.process_time() - begun:6.1f} s", flush=True)
"""


def main() -> None:
    """Compile into an empty folder."""
    for title, model in (("plane", "pendulum"), ("space", "spatial_bracket")):
        print(title)
        with tempfile.TemporaryDirectory() as folder:
            environment = {**os.environ, "NUMBA_CACHE_DIR": folder, "OPENBLAS_NUM_THREADS": "1"}
            scene = ROOT / "models" / model / "scene.toml"
            subprocess.run([sys.executable, "-c", STAGES, str(scene)], cwd=ROOT, env=environment, check=True)


if __name__ == "__main__":
    main()
