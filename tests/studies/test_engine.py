"""The engine of all studies: each job runs once, what a store has does not run again, and outcomes come back to the bit."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from toolkit.foundation.errors import InputError
from toolkit.studies.executor import Executor, run_jobs
from toolkit.studies.store import DesignOutcome, DesignStore, JobState, RunFolder, RunOutcome, StudyFileError, opened_store

ODD = RunOutcome(values={"f": math.nan, "g": 0.1 + 0.2}, gradients={"f": {"x": -math.inf, "y": 5e-324}}, seconds=1 / 3, steps=7)


class Work:
    """Squares of numbers, and which of them were asked for."""

    def __init__(self) -> None:
        self.ran: list[float] = []

    def __call__(self, job: float) -> RunOutcome:
        self.ran.append(job)
        return RunOutcome(values={"square": job**2}, reason="negative" if job < 0 else "")


def bits(outcome: RunOutcome) -> str:
    """All numbers with all digits; nan is no reason to differ."""
    return repr(outcome)


@pytest.mark.parametrize("executor", [Executor(), Executor(threads=3)])
def test_a_job_runs_once_and_a_second_study_runs_what_is_new(tmp_path, executor):
    store, work, told = RunFolder(tmp_path, RunOutcome), Work(), []
    first = run_jobs(work, {"a": 2.0, "b": -3.0}, store, executor, lambda done, total: told.append((done, total)))
    assert (sorted(work.ran), told) == ([-3.0, 2.0], [(0, 2), (1, 2), (2, 2)])
    assert (first["a"].values, first["a"].failed, first["b"].failed) == ({"square": 4.0}, False, True)
    second = run_jobs(work, {"b": -3.0, "c": 0.5, "a": 2.0}, RunFolder(tmp_path, RunOutcome), executor)
    assert sorted(work.ran) == [-3.0, 0.5, 2.0]  # what failed is known too
    assert {key: second[key] for key in first} == first


def test_outcomes_come_back_from_their_folder_to_the_bit_and_damaged_or_foreign_files_are_unknown(tmp_path):
    store = RunFolder(tmp_path, RunOutcome)
    store.keep("odd", ODD)
    found = store.find("odd")
    assert found is not None
    assert bits(found) == bits(ODD)
    assert store.find("other") is None
    file = tmp_path / "odd.json"
    for content in (file.read_bytes()[:-9], b"[]", b'{"values": {"f": "two"}}', b"\xff"):
        file.write_bytes(content)
        assert store.find("odd") is None
    store.keep("odd", ODD)
    assert bits(store.find("odd") or RunOutcome()) == bits(ODD)


def test_a_store_without_a_folder_keeps_nothing():
    store = RunFolder(None, RunOutcome)
    store.keep("odd", ODD)
    assert store.find("odd") is None


def designs(count: int, states: int) -> list[DesignOutcome]:
    """Every third failed; numbers are random bits."""
    rng = np.random.default_rng(5)
    good = [
        DesignOutcome(
            lane=k % 2, design=rng.normal(size=3), values=rng.normal(size=(2, 4)), gradients=rng.normal(size=(2, 4, 3)),
            states=tuple(JobState(rng.normal(size=states), rng.normal(size=1)) for _ in range(2 if states else 0)), seconds=k / 7,
        )
        for k in range(count)
    ]  # fmt: skip
    return [
        DesignOutcome(lane=each.lane, design=each.design, reason=f"no. {k}: ü", seconds=each.seconds) if k % 3 == 1 else each
        for k, each in enumerate(good)
    ]


@pytest.mark.parametrize("states", [0, 5])
def test_designs_come_back_from_their_file_to_the_bit_in_the_order_in_which_they_were_solved(tmp_path, states):
    path, wanted = tmp_path / "study.h5", designs(7, states)
    with opened_store(path, "key") as store:
        for each in wanted:
            store.keep(each.key, each)
    found = list(DesignStore(path, "key"))
    assert len(found) == 7
    for one, other in zip(found, wanted, strict=True):
        assert (one.key, one.reason, one.seconds) == (other.key, other.reason, other.seconds)
        assert (one.values.tobytes(), one.gradients.tobytes()) == (other.values.tobytes(), other.gradients.tobytes())
        assert [(a.tobytes(), b.tobytes()) for a, b in one.states] == [(a.tobytes(), b.tobytes()) for a, b in other.states]
    again = DesignStore(path, "key")
    assert again.find(replace(wanted[0], reason="anything").key) is not None
    assert again.find((1 - wanted[0].lane, wanted[0].design.tobytes())) is None  # of another search


def test_a_file_of_another_study_or_of_none_is_refused_and_left_as_it_is(tmp_path):
    path = tmp_path / "study.h5"
    with opened_store(path, "key") as store:
        for each in designs(3, 0):
            store.keep(each.key, each)
    before = path.read_bytes()
    with pytest.raises(StudyFileError, match="belongs to another study"), opened_store(path, "other"):
        pass
    assert path.read_bytes() == before
    path.write_bytes(b"no HDF5 at all")
    with pytest.raises(InputError), opened_store(path, "key"):
        pass
    assert path.read_bytes() == b"no HDF5 at all"
