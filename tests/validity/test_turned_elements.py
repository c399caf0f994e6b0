"""A component of a displacement that is small beside the whole feels elements that turn, though the whole does not."""

from __future__ import annotations

import re

import numpy as np
import pytest

from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import values_alone
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.loads.torque import Torque
from toolkit.description.design import BodyPoint
from toolkit.description.run_options import RunOptions
from toolkit.responses.motion import Displacement
from toolkit.scene.scene import Scene

SECTION = Section(youngs_modulus=2e9, density=1200.0, thickness=0.02, width=0.03)
STIFFNESS = 2e9 * 0.03 * 0.02**3 / 12


@pytest.mark.parametrize(("tilt", "doubted"), [(0.07, True), (0.7, False)])
def test_a_component_along_a_bent_beam_is_doubted_by_as_much_as_it_is_off(tilt, doubted, tmp_path):
    """A torque at its tip bends a cantilever of 1 m to an arc of 0.03 rad, whose tip is at (sin a / a, (1 - cos a) / a)."""
    save_beam(tmp_path / "beam.h5", np.array([(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)]), SECTION, {"tip": 1.0})
    turn = 0.03
    scene = Scene(
        units="m-kg-s",
        directory=tmp_path,
        points={"T": BodyPoint(body="beam", interface="tip")},
        bodies={"beam": Flexible(model="beam.h5", frame="grounded", angle=tilt)},
        loads={"bend": Torque(body="beam", point="T", torque=turn * STIFFNESS)},
        responses={"along": Displacement(body="beam", point="T", component="x")},
        solver=RunOptions(end_time=1.0, step=0.25, quasi_static=True),
    )
    found = values_alone(Compiled(scene, ()), "transient")
    back, aside = np.sin(turn) / turn - 1, (1 - np.cos(turn)) / turn
    exact = np.cos(tilt) * back - np.sin(tilt) * aside
    off = abs(found.values["along"] / exact - 1)
    assert (off > 0.05) == doubted
    assert found.verdict.trusted != doubted
    if doubted:
        (said,) = found.verdict.reasons
        told = re.search(r"along is off by about ([0-9.]+)%", said)
        assert told is not None
        assert off / 2 < float(told[1]) / 100 < 2 * off
