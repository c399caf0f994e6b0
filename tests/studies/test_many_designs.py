"""Many designs at several places: the same bits everywhere, and nothing lost or repeated by what is killed."""

from __future__ import annotations

import os
import random
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import ffrf
from tests.models.studies import SWEEP, UNCERTAIN, sweep_file
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.hdf5 import reading
from toolkit.studies.executor import Executor, completed
from toolkit.studies.sweep import Swept

ROOT = Path(__file__).parents[2]
SOBOL = SWEEP.replace("levels = 9", 'points = "sobol"\ncount = 24').replace("-90.0", "-45.0")
COMMAND = [sys.executable, "-m", "toolkit.command_line.cli", "sweep"]


def same(one: Swept, other: Swept) -> None:
    """All designs of two sweeps to the bit."""
    assert [each.reason for each in one.solved] == [each.reason for each in other.solved]
    for a, b in zip(one.solved, other.solved, strict=True):
        assert (a.design.tobytes(), a.values.tobytes(), a.gradients.tobytes()) == (
            b.design.tobytes(), b.values.tobytes(), b.gradients.tobytes(),
        )  # fmt: skip


def test_threads_and_processes_give_the_bits_of_one_design_after_the_other(tmp_path):
    path = sweep_file(tmp_path, SOBOL)
    here = ffrf.sweep(path)
    assert 0 < here.failed < 24
    same(ffrf.sweep(path, threads=2), here)
    same(ffrf.sweep(path, processes=2), here)


def test_places_that_cannot_be_meant_are_refused(tmp_path):
    for given in ({"processes": 2, "threads": 2}, {"threads": 2, "dask": "tcp://127.0.0.1:1"}):
        with pytest.raises(InputError, match="Leave out all but one of processes, threads and dask"):
            Executor(**given)
    with pytest.raises(InputError, match="at least 1"):
        Executor(processes=0)
    with pytest.raises(InputError, match="give the address of a scheduler as a text"):
        Executor(dask=8786)


def test_nobody_at_the_address_of_a_scheduler_is_an_error_in_words(monkeypatch):
    monkeypatch.setattr("toolkit.studies.executor.STARTING_SECONDS", 1)
    with pytest.raises(InputError, match=r"no Dask scheduler answers at 'tcp://127.0.0.1:9'.*dask scheduler"):
        list(completed(Executor(dask="tcp://127.0.0.1:9"), str, {1: 2}))


KILLED = """
import os, signal
from toolkit.studies.executor import Executor, completed
from toolkit.studies.executor import StudyError
def end_this_process(task):
    os.kill(os.getpid(), signal.SIGKILL)
if __name__ == "__main__":
    try:
        list(completed(Executor(processes=2), end_this_process, {1: 1, 2: 2}))
    except StudyError as error:
        print(error)
"""


def script(folder: Path, text: str) -> list[str]:
    """Command that runs a text in a process of its own; what is killed around it harms no other test."""
    (folder / "script.py").write_text(text)
    return [sys.executable, str(folder / "script.py")]


def test_a_killed_process_is_an_error_that_says_what_to_do(tmp_path):
    done = subprocess.run(
        script(tmp_path, KILLED),
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"a process of the study was killed.*Ask for fewer processes", done.stdout)


UNGUARDED = """
from toolkit.studies.executor import Executor, completed
from toolkit.studies.executor import StudyError
try:
    list(completed(Executor(processes=2), abs, {1: 1, 2: 2}))
except StudyError as error:
    print(error)
"""
ENDED = """
import sys
from toolkit.studies.executor import Executor, completed
from toolkit.studies.executor import StudyError
if __name__ != "__main__":
    sys.exit("it says why")
try:
    list(completed(Executor(processes=2), abs, {1: 1, 2: 2}))
except StudyError as error:
    print(error)
"""


@pytest.mark.parametrize(
    ("text", "told", "said"),
    [(UNGUARDED, r"^a study in several processes was started outside of `if __name__", "started outside of"),
     (ENDED, r"^the processes of the study ended before their work began.*Ask for fewer processes", "it says why")],
)  # fmt: skip
def test_processes_that_cannot_begin_say_why(tmp_path, text, told, said):
    done = subprocess.run(
        script(tmp_path, text),
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=500,  # three processes import the program: on a machine with thirty others at work that takes minutes
    )
    assert re.search(told, done.stdout)
    assert "memory" not in done.stdout or text is ENDED
    assert said in done.stderr
    assert [line for line in done.stderr.splitlines() if said not in line] == []


SLEEPING = """
import time
from toolkit.studies.executor import Executor, completed
if __name__ == "__main__":
    list(completed(Executor(processes=2), time.sleep, {1: 60, 2: 60}))
"""


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="children are found by what Linux tells")
def test_processes_of_a_killed_study_end_too(tmp_path):
    """They are at their tasks, which would go on for a minute."""
    parent = subprocess.Popen(script(tmp_path, SLEEPING), cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)})
    children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children")
    until = time.monotonic() + 60
    while (
        len(workers := children.read_text().split()) < 3 and time.monotonic() < until
    ):  # both, and the one that cleans up after them
        time.sleep(0.05)
    assert len(workers) == 3
    time.sleep(2)  # they begin to listen
    parent.kill()
    parent.wait()
    until = time.monotonic() + 20
    while any(_works(pid) for pid in workers) and time.monotonic() < until:
        time.sleep(0.05)
    assert not [pid for pid in workers if _works(pid)]


def _works(pid: str) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def kept(folder: Path) -> np.ndarray:
    """Designs of a store; it can be read at any time."""
    with reading(folder / "sweep.h5", lambda reason: InputError(reason)) as content:
        return content.array("design")


OPTIMUM = SWEEP.split("[sweep]")[0].replace("-90.0", "-40.0") + '[objective]\nminimize = "rise"\n[search]\ncertify = false\n'


@pytest.mark.parametrize(("run", "text"), [(ffrf.sweep, SOBOL), (ffrf.uncertainty, UNCERTAIN), (ffrf.optimize, OPTIMUM)])
def test_a_second_run_in_a_folder_in_which_one_works_is_refused_and_the_first_loses_nothing(tmp_path, run, text):
    path, folder, refused = sweep_file(tmp_path, text), tmp_path / "out", []

    def begin_another(done: int, total: int) -> None:
        if done == 2:
            with pytest.raises(InputError, match=r"another run works with .*\.h5.*Wait until it has ended") as error:
                run(path, output=folder)
            refused.append(error)

    run(path, output=folder, progress=begin_another)
    assert len(refused) == 1
    counts: list[int] = []
    run(path, output=folder, progress=lambda done, total: counts.append(done))  # the lock is gone, and nothing else is said
    assert counts


def test_a_second_command_in_a_folder_in_which_one_works_ends_with_an_error_in_words(tmp_path):
    path, folder, ended = sweep_file(tmp_path, SOBOL.replace("count = 24", "count = 4")), tmp_path / "out", []

    def begin_another(done: int, total: int) -> None:
        if done == 2:
            command = [*COMMAND, str(path), "-o", str(folder), "--quiet", "--no-pictures"]
            ended.append(subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False))

    ffrf.sweep(path, output=folder, progress=begin_another)
    assert ended[0].returncode == 1
    assert "another run works with" in ended[0].stderr
    assert len(kept(folder)) == 4


@pytest.mark.robustness
def test_a_thousand_designs_killed_five_times_at_random_are_finished_with_none_lost_and_none_repeated(tmp_path):
    """What is in the store when the process dies stays; each design is in it once, and the numbers are those of a run in peace."""
    text = SOBOL.replace("count = 24", "count = 1000")
    path, folder, chance = sweep_file(tmp_path, text), tmp_path / "out", random.Random(20)
    known = 0
    for _ in range(5):
        process = subprocess.Popen(
            [*COMMAND, str(path), "-o", str(folder), "--quiet", "--no-pictures"], cwd=ROOT, stdout=subprocess.DEVNULL
        )
        deadline = time.monotonic() + 120
        while not ((folder / "sweep.h5").exists() and len(kept(folder)) > known) and time.monotonic() < deadline:
            time.sleep(0.02)
        time.sleep(chance.uniform(0.0, 1.0))
        process.kill()
        assert process.wait() == -signal.SIGKILL
        before, known = known, len(kept(folder))
        assert before < known < 1000
    done: list[int] = []
    found = ffrf.sweep(path, output=folder, progress=lambda k, total: done.append(k))
    assert done[0] == known  # none lost
    assert len(done) == 1 + 1000 - known
    stored = kept(folder)
    assert len(stored) == len(np.unique(stored, axis=0)) == 1000  # none repeated
    same(found, ffrf.sweep(path, processes=2))


@pytest.mark.robustness
def test_a_dask_cluster_of_which_a_worker_is_killed_gives_the_same_bits(tmp_path):
    path = sweep_file(tmp_path, SOBOL.replace("count = 24", "count = 200"))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}

    def started(module: str, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments, "--no-dashboard"]
        return subprocess.Popen(command, env=environment, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    scheduler = started("dask_scheduler", "--host", "127.0.0.1", "--port", address.rpartition(":")[2])
    workers = [started("dask_worker", address, "--nthreads", "1", "--no-nanny") for _ in range(2)]
    done: list[int] = []

    def killing(k: int, total: int) -> None:
        done.append(k)
        if k == 40:
            workers[0].kill()

    try:
        found = ffrf.sweep(path, dask=address, output=tmp_path / "out", progress=killing)
    finally:
        for each in (scheduler, *workers):
            each.kill()
            each.wait()
    assert done == list(range(201))
    same(found, ffrf.sweep(path))
