"""Beams in space that bend far say so, by about as much as floating frames in number bring them elsewhere; twisted ones keep quiet."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from tests.models.spatial_chains import WHERE, chain_scene, save_chain
from toolkit.validity.bodies.deformation import deformation

LENGTH, YOUNG, THICKNESS, WIDTH = 1.0, 1e9, 0.01, 0.02
BENDING = YOUNG * WIDTH * THICKNESS**3 / 12
"""About the axis across the thickness; the orientation of the chain puts that along z."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A straight cantilever of eight elements along x."""
    found = tmp_path_factory.mktemp("cantilever")
    save_chain(found, np.linspace([0.0, 0.0, 0.0], [LENGTH, 0.0, 0.0], 9))
    return found


def loaded(folder, load: str, frames: int = 1):
    """Its equilibrium."""
    text = f"[loads]\npull = {{ {load} }}\n[responses]\n{WHERE}[solver]\nload_steps = 4\n"
    return ffrf.compile(chain_scene(folder, f'frame = "grounded", frames = {frames}', text)).statics()


def pulled(folder, deflection: float, frames: int = 1):
    """By a force at its tip that deflects it so far along the thinner side in linear theory, in parts of its length."""
    for axis in ("y", "z"):  # whichever side is the thin one
        force = {"y": [0.0, 1.0, 0.0], "z": [0.0, 0.0, 1.0]}[axis]
        soft = loaded(folder, f'type = "point-force", body = "beam", point = "tip", force = {[f * 1e-3 for f in force]}')
        if soft.values[axis] == pytest.approx(1e-3 * LENGTH**3 / (3 * BENDING), rel=1e-6):
            break
    size = 3 * BENDING * deflection / LENGTH**2
    return loaded(folder, f'type = "point-force", body = "beam", point = "tip", force = {[f * size for f in force]}', frames)


def tip(run) -> np.ndarray:
    """Displacement of the tip."""
    return np.array([run.values[axis] for axis in "xyz"])


def large(run) -> list[str]:
    """What is said of its deformation."""
    return [each.text for each in run.verdict.warnings if each.code == "large-deformation"]


def test_a_cantilever_is_off_by_what_more_frames_say_and_says_so(folder):
    run, cut = pulled(folder, 0.163), pulled(folder, 0.163, frames=8)  # its tip turns by 14 degrees
    found = deformation(run.solution, "beam")
    assert found.relative == pytest.approx(0.6 * 0.163, rel=0.01)  # closed form of second order; eight elements are straight
    true = np.linalg.norm(tip(run) - tip(cut)) / np.linalg.norm(tip(run))
    assert found.relative == pytest.approx(true, rel=0.1)
    (said,) = large(run)
    assert f"{found.relative:.1%} of its displacement (limit 5%)" in said
    assert not run.verdict.trusted


def test_frames_in_number_and_small_loads_are_trusted(folder):
    assert large(pulled(folder, 0.163, frames=4)) == []
    assert large(pulled(folder, 0.05)) == []


def test_a_twisted_shaft_that_stays_straight_says_nothing(folder):
    run = loaded(folder, 'type = "torque", body = "beam", point = "tip", torque = [0.5, 0.0, 0.0]')
    assert large(run) == []
    assert deformation(run.solution, "beam").rotation > 0.1
