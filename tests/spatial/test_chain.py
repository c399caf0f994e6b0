"""The flexible chain that the benchmark measures."""

from __future__ import annotations

from tests.benchmarks.space import STEPS, hanging
from toolkit.analyses.transient import simulate
from toolkit.system.system import compile_scene
from toolkit.validity.energy_balance import energy_balance


def test_the_benchmarks_chain_swings_with_its_balls_closed_and_its_energy_kept(tmp_path):
    """At 1 ms: index 1 keeps joints to about the square of the step, and the scheme damps the beams' fast modes a little."""
    solution = simulate(compile_scene(hanging(tmp_path, 2, 4)))
    assert solution.steps == STEPS
    assert solution.drift < 1e-5
    assert energy_balance(solution).relative_defect < 0.01
