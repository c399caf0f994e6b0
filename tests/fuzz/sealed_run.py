"""Changed HDF5 files whose checksums are right, as many as one likes: python -m tests.fuzz.sealed_run COUNT SEED."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from tests.foundation.test_fuzz_hdf5 import judged
from tests.fuzz.good_files import PREPARED, batch

PIECE = 500  # files of one process, whose time is bounded

if __name__ == "__main__":
    count, seed = int(sys.argv[1]), int(sys.argv[2])
    for kind in PREPARED:
        for first in range(0, count, PIECE):
            with tempfile.TemporaryDirectory() as folder:
                lines, memory = batch(Path(folder), kind, min(PIECE, count - first), seed + first)
                print(kind, first, dict(judged(lines, memory)), f"{memory} MB", flush=True)
