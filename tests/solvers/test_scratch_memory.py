"""Memory that one run leaves to the next, of the same scene at other numbers: it holds what new memory does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.compiled.calls import in_memory
from toolkit.linear.sparse_analysis import LUPlan
from toolkit.solvers.transient.step_memory import Memory, allocate_memory, taken_memory
from toolkit.system.renewal import renewed
from toolkit.system.system import System

MODELS = Path(__file__).parents[2] / "models"
SCENES = ("morphing_wing", "bricard", "governor", "flexible_crank")
STATES = ("q", "v", "a", "multipliers", "dq", "dv", "da", "dmultipliers")


def arrays(part: Any) -> list[np.ndarray]:
    """All that a run writes to, but memory that dense factors fill as a whole."""
    if isinstance(part, np.ndarray):
        return [part]
    names = [name for name in getattr(part, "_fields", range(len(part))) if name != "dense"] if isinstance(part, tuple) else []
    below = [getattr(part, name) if isinstance(name, str) else part[name] for name in names]
    return [array for each in below if not isinstance(each, LUPlan) for array in arrays(each)]


def pair(model: str) -> tuple[System, System]:
    """A scene with its design variables, and the same at another number."""
    scene = read_scene(MODELS / model / "scene.toml")
    path = scene.paths_of(list(scene.design)[-1])[0]
    system = prepare(scene, list(scene.design))
    return system, renewed(system, scene.with_number(path, 1.001 * scene.number(path)), [path])


@pytest.mark.parametrize("model", SCENES)
def test_a_run_in_the_memory_of_another_one_has_its_very_states(model):
    first, other = pair(model)
    short = first.scene.solver.model_copy(update={"end_time": 5 * first.scene.solver.step})
    simulate(first, short)
    taken, fresh = taken_memory(other, True), prepare(other.scene, list(other.design.names))
    other.give_back(Memory, taken)
    found, wanted = simulate(other, short), simulate(fresh, short)
    assert taken_memory(other, True) is taken  # of the first run, and of the second
    for name in STATES:
        assert np.array_equal(getattr(found, name), getattr(wanted, name)), name


@pytest.mark.parametrize("model", SCENES)
def test_memory_that_is_taken_over_holds_what_new_memory_does(model):
    system, other = pair(model)
    simulate(system, RunOptions(**{**dict(system.scene.solver), "end_time": 2 * system.scene.solver.step}))
    taken = taken_memory(other, True)
    new = allocate_memory(other.plan, other.lu_plan, other.weights, other.dtype)
    for found, wanted in zip(arrays(taken._replace(work=())), arrays(new._replace(work=())), strict=True):
        assert np.array_equal(found, wanted)


def test_two_runs_at_once_have_memory_of_their_own():
    system, _ = pair("morphing_wing")
    simulate(system, progress=lambda done, total: simulate(system) and None)
    one, other = taken_memory(system, True), taken_memory(system, True)
    assert one is not other


def test_shapes_are_told_apart():
    record = Memory(**dict.fromkeys(Memory._fields, np.zeros(3)))
    longer = record._replace(guess=np.zeros(4))
    assert in_memory(record).same_shapes(in_memory(record._replace(guess=np.ones(3))))
    assert not in_memory(record).same_shapes(in_memory(longer))
    assert not in_memory(record).same_shapes(in_memory(record._replace(guess=np.zeros((3, 1)))))
