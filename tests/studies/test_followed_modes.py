"""Studies of modes: frequencies by the shapes of their modes, against closed forms, where others cross them and where they mix."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import ffrf
from tests.models.truss import force_slope, height, write_truss
from tests.responses.test_vibration import MASS, STIFFNESS, blocks
from toolkit.components.loads.springs import SpringDamper
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.studies.optimization.optimize import optimized
from toolkit.studies.problem import Problem, problem_of
from toolkit.studies.solved_design import solve_design
from toolkit.studies.study_file import Study, read_study

FIRST = "loads.springB0.stiffness"


def study(**tables: object) -> Study:
    """Two blocks, the first on the softer spring where the scene stands; its stiffness may become that of a harder one."""
    given = {
        "scene": "",
        "analysis": "modes",
        "variables": {FIRST: {"between": [100.0, 2000.0]}},
        "objective": {"minimize": {"frequency_1": 1.0, "frequency_2": 1.0}},
        "search": {"certify": False},
    }
    return Study.model_validate(given | tables)


def coupled(scene: Scene, stiffness: float) -> Scene:
    """With a spring between every two blocks that stand side by side."""
    names = [name for name in scene.bodies if name.startswith("B")]
    pairs = pairwise(names)
    springs = {f"{a}{b}": SpringDamper(bodies=(a, b), points=(a, b), stiffness=stiffness) for a, b in pairs}
    return scene.model_copy(update={"loads": {**scene.loads, **springs}})


def at(problem: Problem, stiffness: float) -> dict[str, tuple[float, float]]:
    """Frequencies of a design with their derivatives."""
    found = solve_design(problem, 0, np.array([stiffness]), None)
    assert not found.failed, found.reason
    return {name: (found.values[0, k], found.gradients[0, k, 0]) for k, name in enumerate(problem.responses)}


def test_a_frequency_is_that_of_its_block_also_beyond_where_the_other_crosses_it():
    problem = problem_of(study(), blocks(STIFFNESS, 2 * STIFFNESS))
    other = np.sqrt(2 * STIFFNESS / MASS) / (2 * np.pi)
    for stiffness in (200.0, 599.0, 601.0, 1500.0):
        mine = np.sqrt(stiffness / MASS) / (2 * np.pi)
        found = at(problem, stiffness)
        assert found["frequency_1"] == pytest.approx((mine, mine / stiffness / 2), rel=1e-10)  # round-off
        assert found["frequency_2"] == pytest.approx((other, 0.0), rel=1e-10, abs=1e-15)


def test_an_optimum_of_the_first_block_lies_beyond_the_crossing():
    """3 Hz, where by its order the first frequency cannot get above that of the other block, 2.76 Hz."""
    wanted = study(
        objective={"minimize": "frequency_2"},
        constraints={"frequency_1": {"above": 3.0}},
        variables={FIRST: {"between": [100.0, 2000.0]}, "loads.springB1.stiffness": {"between": [500.0, 700.0]}},
    )
    found = optimized(problem_of(wanted.model_copy(update={"objective": wanted.objective}), blocks(STIFFNESS, 2 * STIFFNESS)))
    assert found.success, found.verdict
    assert found.variables[FIRST] >= MASS * (2 * np.pi * 3.0) ** 2 * (1 - 1e-5)
    assert found.values["frequency_2"] == pytest.approx(np.sqrt(500.0 / MASS) / (2 * np.pi), rel=1e-9)
    assert found.units["frequency_1"] == "1/s"


def test_modes_that_mix_are_refused_in_words():
    """Three blocks with springs between them, alike at the design: no mode is one block's any more."""
    scene = coupled(blocks(STIFFNESS, 2 * STIFFNESS, 2 * STIFFNESS), 30.0)
    found = solve_design(problem_of(study(), scene), 0, np.array([2 * STIFFNESS]), None)
    assert "frequency_1: no mode is like the one that has this number where the scene stands" in found.reason
    assert "assurance of 0.4" in found.reason
    assert at(problem_of(study(), scene), 2000.0)["frequency_1"][0] == pytest.approx(5.03, abs=0.05)  # the block alone: 5.03 Hz


TRUSS = """
scene = "scene.toml"
analysis = "modes"
[variables]
"loads.push.force.y" = { between = [-42.0, -10.0] }
[objective]
minimize = "rise"
[constraints]
frequency_1 = { above = 2.0 }
load_margin = { above = 1.01 }
"""


def test_the_load_at_which_the_truss_has_a_frequency_is_that_of_the_closed_form(tmp_path):
    """f^2 = - (dF/dy) / m / (2 pi)^2, with the limit on the frequency active, and the gradient certified."""
    found = ffrf.optimize(write_truss(tmp_path, TRUSS))
    assert found.success, found.verdict
    load = -found.variables["loads.push.force.y"]
    stiffness = -force_slope(height(load))
    assert np.sqrt(stiffness) / (2 * np.pi) == pytest.approx(2.0, rel=1e-5)
    assert found.values["frequency_1"] == pytest.approx(2.0, rel=1e-5)


WRONG = {
    "too many": (TRUSS.replace("frequency_1", "frequency_2"), "frequency_2: the scene has 1 modes"),
    "statics": (
        TRUSS.replace('"modes"', '"statics"'),
        'constraints.frequency_1: (.|\n)*Write analysis = "modes", or .*number = 1',
    ),
    "unknown": (TRUSS.replace("frequency_1", "frequency_0"), "possible here: .*frequency_1, frequency_2, ..."),
    "taken": (TRUSS + '[responses]\nfrequency_1 = { type = "frequency" }\n', "responses.frequency_1 is built in"),
}


@pytest.mark.parametrize("name", WRONG)
def test_frequencies_that_are_not_there_are_refused_in_words(tmp_path, name):
    text, words = WRONG[name]
    with pytest.raises((InputError, ArithmeticError), match=words):
        optimized(problem_of(read_study(write_truss(tmp_path, text))))


def test_modes_of_a_scene_that_spins_are_not_followed():
    scene = blocks(STIFFNESS)
    spinning = scene.model_copy(update={"solver": scene.solver.model_copy(update={"equilibrium": "spinning"})})
    with pytest.raises(InputError, match=r"followed about an equilibrium at rest(.|\n)*number = 1"):
        problem_of(study(objective={"minimize": "frequency_1"}), spinning)
