"""Statics of a stiff bar that its weight alone holds: by 1e-14 of what stretches its short elements, and yet beyond doubt."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare
from toolkit.analyses.statics import solve_statics
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.gravity import Gravity
from toolkit.description.design import BodyPoint
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.responses.motion import Displacement
from toolkit.scene.scene import Scene

STEEL = Section(youngs_modulus=2.1e11, density=7850.0, thickness=0.1, width=0.01)


def hanging(folder: Path, at: str, g: float) -> Scene:
    """A bar of 1 m and 40 elements below a hinge at its beginning or its middle."""
    nodes = np.stack([np.zeros(41), -np.linspace(0.0, 1.0, 41)], axis=1)
    file = save_beam(folder / "bar.h5", nodes, STEEL, {"top": 0.0, "middle": 0.5, "tip": 1.0})
    return Scene(
        units="m-kg-s",
        directory=file.parent,
        points={name: BodyPoint(body="bar", interface=name) for name in ("top", "middle", "tip")},
        bodies={"bar": Flexible(model=file.name)},
        joints={"hinge": Revolute(bodies=("bar", "ground"), point=at)},
        loads={"weight": Gravity(acceleration=(0.0, -g))},
        responses={"longer": Displacement(body="bar", point="tip", component="y")},
        solver=RunOptions(end_time=1.0, step=0.1),
    )


def test_a_stiff_bar_hangs_where_it_is(tmp_path):
    """It grows by rho g L^2 / 2 E."""
    solution = solve_statics(prepare(hanging(tmp_path, "top", 9.81)))
    assert evaluate_responses(solution)["longer"] == pytest.approx(-7850.0 * 9.81 / 2 / 2.1e11, rel=1e-6)
    assert solution.verdict.trusted


@pytest.mark.parametrize(("at", "g"), [("top", -9.81), ("middle", 9.81)], ids=["on its head", "at its centre"])
def test_a_bar_that_its_weight_does_not_hold_is_refused(tmp_path, at, g):
    with pytest.raises(ToolkitError):
        solve_statics(prepare(hanging(tmp_path, at, g)))
