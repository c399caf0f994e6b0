"""Smooth maxima with a parameter that is too small for the size of what they are of."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam

STRESS = 6 * 0.3 / (0.02 * 0.01**2)
"""Of a cantilever of 1 m under 0.3 N at its tip, in Pa: 6 F L / (b t^2), 0.9 MPa."""
SCENE = """units = "m-kg-s"
[points]
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded" }
[loads]
pull = { type = "point-force", body = "beam", point = "tip", force = [0.0, 0.3] }
[responses]
smooth = { type = "ks-stress", body = "beam", aggregation = RHO }
"""


def statics(folder, aggregation: float) -> ffrf.Run:
    nodes = np.column_stack([np.linspace(0, 1, 11), np.zeros(11)])
    save_beam(folder / "beam.h5", nodes, Section(youngs_modulus=2e11, density=7800.0, thickness=0.01, width=0.02), {"tip": 1.0})
    (folder / "scene.toml").write_text(SCENE.replace("RHO", str(aggregation)))
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml")).statics()


@pytest.mark.parametrize(("aggregation", "times", "codes"), [(1e-3, 1.01, ()), (1e-7, 30, ("loose-maximum",))])
def test_a_parameter_that_makes_another_number_of_the_largest_stress_is_told(tmp_path, aggregation, times, codes):
    """rho sigma = 900 and 0.09: the former is next to the largest stress, the latter 41 ln(2) / rho from it."""
    run = statics(tmp_path, aggregation)
    assert STRESS * (1 - 1e-9) <= run.values["smooth"] <= times * 1.5 * STRESS
    assert (run.values["smooth"] > times / 1.5 * STRESS) or not codes
    assert run.verdict.codes == codes
    assert all(f"{STRESS:.4g}" in each.text for each in run.verdict.warnings)
