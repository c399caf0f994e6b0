"""Kernels that run for long leave Python to other threads."""

from __future__ import annotations

import threading

import numpy as np

from toolkit.foundation.kernel import loop
from toolkit.solvers.transient.generalized_alpha import integrate
from toolkit.solvers.transient.step_gradients import integrate_backwards

MOST = 3_000_000_000
"""Turns after which a loop gives up: some seconds, in which any other thread has its turn if it may."""


@loop
def wait(told, turns, most):
    """Count until somebody else tells that it is enough."""
    while told[0] == 0 and turns[0] < most:
        turns[0] += 1


def test_another_thread_can_end_a_loop_that_runs():
    told, turns = np.zeros(1, np.int64), np.zeros(1, np.int64)
    wait(told, turns, 10)  # compiled from here on
    turns[0] = 0
    runs = threading.Thread(target=wait, args=(told, turns, MOST))
    runs.start()
    while not turns[0]:  # it has begun
        assert runs.is_alive()
    told[0] = 1
    runs.join()
    assert 0 < turns[0] < MOST


def test_the_loops_over_time_are_such_loops():
    assert type(integrate) is type(integrate_backwards) is type(wait)
    assert integrate.targetoptions["nogil"] is integrate_backwards.targetoptions["nogil"] is True
