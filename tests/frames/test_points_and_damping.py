"""Points that move along a cut body, and its damping."""

from __future__ import annotations

import numpy as np
import pytest

import ffrf
from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from toolkit.foundation.errors import InputError

NODES = np.column_stack([np.linspace(0, 1, 9), np.zeros(9)])
SCENE = """units = "m-kg-s"
[points]
tip = { body = "beam", interface = "tip" }
mid = { body = "beam", interface = "mid", arc_length = ARC }
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded", frames = FRAMES }
[loads]
pull = { type = "point-force", body = "beam", point = "mid", force = [0.0, 0.02] }
[design]
s = "points.mid.arc_length"
[responses]
y = { type = "displacement", body = "beam", point = "tip", component = "y" }
"""
VIBRATING = """units = "m-kg-s"
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded", frames = FRAMES }
[responses]
f1 = { type = "frequency", number = 1 }
z1 = { type = "damping-ratio", number = 1 }
f3 = { type = "frequency", number = 3 }
z3 = { type = "damping-ratio", number = 3 }
"""


def loaded(folder, frames: int, arc: float = 0.47, damping: float = 0.0) -> ffrf.Run:
    """Equilibrium of a cantilever of eight elements under a force at a point along it, with gradients."""
    section = Section(youngs_modulus=1e9, density=1e3, thickness=0.01, width=0.02, damping_mass=damping)
    save_beam(folder / "beam.h5", NODES, section, {"tip": 1.0, "mid": 0.47})
    (folder / "scene.toml").write_text(SCENE.replace("ARC", str(arc)).replace("FRAMES", str(frames)))
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml"), variables=["s"]).statics(gradients=True)


def test_a_force_that_moves_along_a_cut_body_has_the_gradient_of_linear_theory(tmp_path):
    """y = F s^2 (3 L - s) / 6 EI for a tip at L: dy/ds = F s (2 L - s) / 2 EI, of a load that bends by a hundredth of the length."""
    exact = 0.02 * 0.47 * (2 - 0.47) / 2 / (1e9 * 0.02 * 0.01**3 / 12)
    for frames in (1, 2, 8):
        assert loaded(tmp_path, frames).gradients["y"]["s"] == pytest.approx(exact, rel=2e-3)  # large rotation: (y / L)^2


def test_a_point_at_a_node_has_no_derivative_along_a_cut_body_and_says_so(tmp_path):
    assert loaded(tmp_path, 1, arc=0.5).gradients["y"]["s"] > 0
    with pytest.raises(InputError, match=r"lies at a node of the body.*has no derivative there"):
        loaded(tmp_path, 2, arc=0.5)


def test_damping_by_the_stiffness_is_what_it_is_with_one_frame(tmp_path):
    """D = beta K damps a mode by beta omega / 2, however many frames the body has."""
    section = Section(youngs_modulus=1e9, density=1e3, thickness=0.01, width=0.02, damping_stiffness=1e-3)
    save_beam(tmp_path / "beam.h5", NODES, section, {"tip": 1.0})
    for frames in (1, 3):
        (tmp_path / "scene.toml").write_text(VIBRATING.replace("FRAMES", str(frames)))
        run = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()
        for number in (1, 3):
            expected = 1e-3 * np.pi * run.values[f"f{number}"]
            assert run.values[f"z{number}"] == pytest.approx(
                expected, rel=1e-8
            )  # round-off of a slow vibration of a bar that is stiff along itself
        assert run.verdict.trusted


def test_elements_with_mass_damping_of_their_own_are_doubted_where_the_frame_moves_alone(tmp_path):
    """Their damping acts on what moves in the frame: a bar clamped to the ground has it right, several frames lose it."""
    section = Section(youngs_modulus=1e9, density=1e3, thickness=0.01, width=0.02, damping_mass=5.0)
    save_beam(tmp_path / "beam.h5", NODES, section, {"tip": 1.0}, separate=("damping_mass",))
    for frames, codes in ((1, ()), (3, ("frame-damping",))):
        (tmp_path / "scene.toml").write_text(VIBRATING.replace("FRAMES", str(frames)))
        run = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml")).statics()
        right = 5.0 / (4 * np.pi * run.values["f1"])
        assert run.verdict.codes == codes
        assert (run.values["z1"] == pytest.approx(right, rel=1e-8)) == (frames == 1)
