"""kill -9 in the middle of a write: afterwards there is the old file, whole, or the new one, whole; never a part of one."""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tests.fuzz.good_files import good_model, good_results
from toolkit.files.results_file import load_results

pytestmark = pytest.mark.robustness

ROOT = Path(__file__).parents[2]
WRITER = """
import os
import sys
import time
from dataclasses import replace
from pathlib import Path
import numpy as np
from toolkit.reduced_model.file import load, save
from toolkit.files.results_file import load_results, save_results

folder = Path(sys.argv[1])
os.fsync = lambda _: time.sleep(0.1)  # a slow disk: files are built in memory, and are on their way to the disk for a moment only
model, results = load(folder / "good.h5"), load_results(folder / "results" / "good.h5")
writing = np.random.default_rng(0).normal(size=(20_000, results.q.shape[1]))  # large, and slow to pack
writing = dict(times=np.arange(20_000.0), q=writing, v=writing, a=writing)
for name in ("multipliers", "dq", "dv", "da", "dmultipliers"):
    writing[name] = np.zeros((20_000, *getattr(results, name).shape[1:]))
results = replace(results, bodies={}, **writing)
while True:
    save(model, folder / "model.h5")
    save_results(results, folder / "run.h5")
    print("written", flush=True)
"""
KILLS = 6


def test_a_killed_write_leaves_the_old_file_or_the_new_one(tmp_path):
    (tmp_path / "results").mkdir()
    good_model(tmp_path)
    good_results(tmp_path / "results")
    rng = random.Random(1)
    for _ in range(KILLS):
        writer = subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path)], cwd=ROOT, stdout=subprocess.PIPE)
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"written\n"
        time.sleep(rng.uniform(0.0, 0.5))  # s; one round of writing takes some 0.4 s
        writer.send_signal(signal.SIGKILL)
        assert writer.wait() == -signal.SIGKILL
        writer.stdout.close()
        assert (tmp_path / "model.h5").read_bytes() == (tmp_path / "good.h5").read_bytes()
        assert np.array_equal(load_results(tmp_path / "run.h5").times, np.arange(20_000.0))
    stale = list(tmp_path.glob("*.tmp.h5"))  # some kills hit the middle of a write, and nothing but these is left of them
    assert stale
    assert {path.name for path in tmp_path.iterdir()} - {path.name for path in stale} == {
        "good.h5", "scene.toml", "results", "model.h5", "run.h5"
    }  # fmt: skip
