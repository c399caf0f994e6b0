"""Kept factors of modified Newton: what they leave of the unknowns is bounded over the whole run, whatever the step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.models.scenes import WING
from toolkit.analyses.sensitivity.preparation import frozen
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.system.system import compile_scene

FOUR_BARS = Path(__file__).parents[2] / "models" / "four_bar_chain" / "scene.toml"
ALLOWED = 1e-7
"""Of the model size, or rad: a hundred default tolerances, and ten times as much for the singular positions that the bars pass."""


def both(scene: Scene, design: tuple[str, ...] = (), **options) -> tuple[Solution, Solution]:
    """By full and by modified Newton, with the same steps."""
    system = compile_scene(scene, list(design))
    full = simulate(system, RunOptions(**{**dict(scene.solver), **options}))
    steps = {**dict(frozen(scene.model_copy(update={"solver": full.options}), full).solver), "newton": "modified"}
    return full, simulate(system, RunOptions(**steps))


def apart(full: Solution, modified: Solution) -> float:
    """Largest difference at any time, of the model size or in rad."""
    return float(np.abs(full.system.weights[: full.system.n_q] * (modified.q - full.q)).max())


@pytest.mark.parametrize("formulation", ["index-1", "index-3", "ggl"])
@pytest.mark.parametrize("step", [1e-2, 8e-3, 3e-3, 1e-3, 3e-4])
def test_modified_newton_is_as_accurate_as_full_newton_at_every_step(formulation, step):
    """With the tolerance as the only criterion the difference was 1e-3 to 2e-2: it grew while the error of the steps fell."""
    scene = read_scene(FOUR_BARS, {"solver.end_time": "2.0"})
    full, modified = both(scene, step=step, formulation=formulation)
    assert apart(full, modified) <= ALLOWED
    assert modified.newton_iterations > full.newton_iterations  # it did keep its factors


def test_gradients_with_kept_factors_are_those_of_full_newton():
    scene = read_scene(FOUR_BARS, {"solver.end_time": "1.0"})
    full, modified = both(scene, ("g_y", "m_1"), step=3e-3)
    # what moves the states by 1e-8 moves their derivatives by as much of their own size
    np.testing.assert_allclose(modified.dq, full.dq, rtol=0, atol=ALLOWED * np.abs(full.dq).max())


def test_a_slow_correction_with_kept_factors_does_not_pass_for_round_off():
    """Newton with the exact Jacobian is content where corrections do not shrink; the one before must have been exact too."""
    run = simulate(
        compile_scene(read_scene(FOUR_BARS)), RunOptions(end_time=5.0, step=1e-2, formulation="ggl", newton="modified")
    )
    assert run.correction <= run.options.tolerance


def test_forces_without_inertia_do_not_suffer_from_kept_factors():
    """Stiffness makes a force of what is left in the coordinates: 1e-7 of it with the tolerance as the only criterion."""
    full, modified = both(read_scene(WING, {"solver.scheme": "arnold-bruels"}), quasi_static=True, step=5e-3)
    sizes = np.abs(full.multipliers).max()
    np.testing.assert_allclose(modified.multipliers, full.multipliers, rtol=0, atol=1e-9 * sizes)


def test_chosen_steps_are_repeated_by_modified_newton():
    """Steps whose lengths change: as accurate, by the steps that full Newton has chosen."""
    full, modified = both(read_scene(FOUR_BARS, {"solver.end_time": "1.0"}), step=0.1, local_error=1e-8)
    assert apart(full, modified) <= ALLOWED
