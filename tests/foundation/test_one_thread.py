"""Linear algebra has one thread inside of an analysis, and as many as before after it."""

from __future__ import annotations

import json
import os
import subprocess
import sys

CODE = """
import json, threading
import scipy.linalg
from threadpoolctl import threadpool_info
from toolkit.foundation.processes import one_thread

def threads():
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}

seen = {"before": threads()}
with one_thread():
    seen["inside"] = threads()
    with one_thread():
        pass
    seen["behind an inner one"] = threads()
seen["after"] = threads()

begun, go = threading.Event(), threading.Event()

@one_thread()
def long():
    begun.set()
    go.wait()

other = threading.Thread(target=long)
with one_thread():
    other.start()
    begun.wait()
seen["while another thread works"] = threads()
go.set()
other.join()
seen["after both"] = threads()
try:
    with one_thread():
        raise ValueError
except ValueError:
    seen["after an error"] = threads()
print(json.dumps({name: sorted(found) for name, found in seen.items()}))
"""


def test_threads_are_given_back_by_the_last_of_nested_and_of_parallel_analyses():
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "2", "MKL_NUM_THREADS": "2"}
    done = subprocess.run([sys.executable, "-c", CODE], env=environment, capture_output=True, text=True, check=True)
    seen = json.loads(done.stdout)
    one = {name for name, found in seen.items() if found == [1]}
    other = "while another thread works"
    assert one - {other} == {"inside", "behind an inner one"} | ({*seen} - {other} if seen["before"] == [1] else set())
    assert len({tuple(found) for name, found in seen.items() if name not in {*one, other}}) <= 1
