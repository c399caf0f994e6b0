"""Forces along a column that alternate with twice the frequency of its bending, against finite elements with geometric stiffness."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import ffrf
from tests.validity.test_flutter import beam_matrices, save_column
from toolkit.scene.scene import Scene

FIRST = 0.5595935
"""Lowest frequency of a cantilever of length, bending stiffness and mass per length 1."""
ALTERNATES = 0.08 * np.pi**2 / 4
"""Part of its critical load."""
KICK, END, STEP = 0.003, 45 / FIRST, 1 / FIRST / 30
SCENE = """units = "m-kg-s"
[points]
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded", frames = FRAMES }
[loads]
push = { type = "point-force", body = "beam", point = "tip", force = [-FORCE, 0.0], curve = { type = "harmonic", frequency = RATE } }
kick = { type = "point-force", body = "beam", point = "tip", force = [0.0, KICK], curve = { type = "ramp", final = 0.0, RAMP } }
[responses]
y = { type = "time-max", of = { type = "displacement", body = "beam", point = "tip", component = "y" }, measure = "absolute" }
[solver]
end_time = END
step = STEP
rho_inf = 1.0
"""


def column(folder: Path, rate: float, frames: int = 1, kick: float = KICK, damping: float = 0.0) -> Scene:
    save_column(folder, damping)
    text = SCENE.replace("RAMP", "initial = 1.0, start = 0.1, end = 0.2")
    numbers = {"FRAMES": frames, "FORCE": ALTERNATES, "RATE": rate, "KICK": kick, "END": END, "STEP": STEP}
    for name, value in numbers.items():
        text = re.sub(rf"\b{name}\b", repr(value), text)
    (folder / "scene.toml").write_text(text)
    return ffrf.read_scene(folder / "scene.toml")


def largest(rate: float, damping: float = 0.0) -> float:
    """Of the tip, by the trapezoidal rule at half the step."""
    K, M, G = beam_matrices(6)
    h, count = STEP / 2, int(2 * END / STEP)
    y, v, found = np.zeros(len(K)), np.zeros(len(K)), 0.0
    a = np.linalg.solve(M, KICK * np.eye(len(K))[-2])
    for t in h * np.arange(1, count + 1):
        force = KICK * np.clip((0.2 - t) / 0.1, 0.0, 1.0) * np.eye(len(K))[-2]
        stiffness = K - ALTERNATES * np.cos(2 * np.pi * rate * t) * G
        known, moving = y + h * v + h**2 / 4 * a, v + h / 2 * a
        a = np.linalg.solve(M + h / 2 * damping * K + h**2 / 4 * stiffness, force - stiffness @ known - damping * K @ moving)
        y, v = known + h**2 / 4 * a, moving + h / 2 * a
        found = max(found, abs(y[-2]))
    return found


def told(run: ffrf.Run) -> list[str]:
    return [each.text for each in run.verdict.warnings if each.code == "parametric-resonance"]


def test_a_vibration_that_alternating_forces_make_grow_is_doubted_by_its_true_size(tmp_path):
    run = ffrf.compile(column(tmp_path, 2 * FIRST)).simulate()
    times = largest(2 * FIRST) / run.values["y"]
    assert times > 50
    assert not run.verdict.trusted
    assert float(told(run)[0].split("is up to ")[1].split(" times")[0]) == pytest.approx(times, rel=0.3)


@pytest.mark.parametrize(("rate", "damping"), [(2.4 * FIRST, 0.0), (2 * FIRST, 0.0137)])
def test_what_does_not_grow_is_not_doubted(tmp_path, rate, damping):
    """Beside twice the frequency, and with a damping of 2.4 % against a growth of 2 %."""
    run = ffrf.compile(column(tmp_path, rate, damping=damping)).simulate()
    assert run.values["y"] == pytest.approx(largest(rate, damping), rel=0.2)
    assert told(run) == []


@pytest.mark.parametrize("frames", [1, 2])
def test_a_straight_column_that_the_least_disturbance_would_set_off_is_doubted(tmp_path, frames):
    """Whether the equations know the geometric stiffness or not."""
    run = ffrf.compile(column(tmp_path, 2 * FIRST, frames, kick=0.0)).simulate()
    assert "hardly anything sets it off" in told(run)[0]
