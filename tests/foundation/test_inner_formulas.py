"""Formulas that only others call are made ready for the compiler when it asks for them, once."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from toolkit.foundation.kernel import inner, kernel


def test_nothing_is_made_ready_before_a_caller_is_compiled():
    @inner
    def twice(x):
        return 2 * x

    @kernel
    def fill(found):
        found[0] = twice(found[0])

    assert "overloads" not in vars(twice)
    found = np.ones(1)
    fill(found)
    assert found[0] == 2
    from_disk = sum(fill.stats.cache_hits.values())  # where an earlier run has compiled it, nothing is needed
    assert len(vars(twice).get("overloads", ())) == (0 if from_disk else 1)


def test_threads_that_need_a_formula_at_once_find_the_same_one():
    @inner
    def same(x):
        return x

    found, begin = [], threading.Barrier(4)

    def ask() -> None:
        begin.wait()
        found.append(same._compiler)

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert len(found) == 4
    assert len(set(map(id, found))) == 1


def test_a_call_from_python_is_refused():
    @inner
    def same(x):
        return x

    with pytest.raises(TypeError, match="only other kernels call"):
        same(1.0)
    assert not hasattr(same, "what_nobody_has")
