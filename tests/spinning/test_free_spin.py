"""Vibrations at the end of a spin that nothing holds or drives: its own two roots are zero, and those of its parts are as they are."""

from __future__ import annotations

import numpy as np
import pytest

from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import values_alone
from toolkit.components.bodies.rigid import Rigid
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.slider import Slider
from toolkit.components.loads.springs import SpringDamper
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.responses.vibration import DampingRatio, Frequency
from toolkit.scene.scene import Scene

MASS, TABLE, STIFFNESS, DAMPING, FREE_LENGTH = 2.0, 0.501, 50.0, 20.0, 1.5


def table() -> Scene:
    """A block of 2 kg on a radial spring on a table that turns freely with 3 rad/s, steady after some seconds."""
    return Scene(
        units="m-kg-s",
        points={"O": Point(x=0.0, y=0.0), "P": Point(x=2.0, y=0.0)},
        bodies={
            "table": Rigid(mass=1.0, inertia=TABLE - 1e-3, center="O", angular_velocity=3.0),
            "block": Rigid(mass=MASS, inertia=1e-3, center="P"),
        },
        joints={
            "O": Revolute(bodies=("table", "ground"), point="O"),
            "S": Slider(bodies=("block", "table"), point="P", axis=(1.0, 0.0), lock_rotation=True),
        },
        loads={
            "k": SpringDamper(
                bodies=("block", "table"), points=("P", "O"), stiffness=STIFFNESS, damping=DAMPING, length=FREE_LENGTH
            )
        },
        responses={
            "f1": Frequency(when="end"),
            "f2": Frequency(number=2, when="end"),
            "damping": DampingRatio(when="end"),
        },
        solver=RunOptions(end_time=10.0, step=0.01),
    )


def radial_root() -> complex:
    """Of m r'' = m r w^2 - k (r - l) - c r' with the momentum w (J + m r^2) of the start, about where it comes to rest."""
    momentum, r = 3.0 * (TABLE + MASS * 2.0**2), 2.0
    for _ in range(50):  # Newton's method for the steady radius
        inertia = TABLE + MASS * r**2
        force = MASS * r * (momentum / inertia) ** 2 - STIFFNESS * (r - FREE_LENGTH)
        slope = MASS * (momentum / inertia) ** 2 * (1 - 4 * MASS * r**2 / inertia) - STIFFNESS
        r -= force / slope
    return complex(max(np.roots([MASS, DAMPING, -slope]), key=lambda s: s.imag))


def test_a_free_spin_has_no_vibration_of_its_own():
    s, found = radial_root(), values_alone(Compiled(table(), ()), "transient")
    assert found.values["f1"] == 0.0
    assert found.values["f2"] == pytest.approx(s.imag / (2 * np.pi), rel=1e-4)  # what ten seconds leave of the way there
    assert found.values["damping"] == pytest.approx(-s.real / abs(s), rel=1e-4)
    assert found.verdict.trusted
