"""Vibrations under forces that follow a column (Beck's), against its own finite elements with geometric stiffness."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import scipy

import ffrf
from preprocessing.elements.section import Section
from tests.models.beam_models import save_beam
from toolkit.scene.scene import Scene

ELEMENTS = 16
NODES = np.column_stack([np.linspace(0, 1, ELEMENTS + 1), np.zeros(ELEMENTS + 1)])
SCENE = """units = "m-kg-s"
[points]
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded", frames = FRAMES }
[loads]
push = { type = "point-force", body = "beam", point = "tip", force = [-FORCE, 0.0], frame = "body" }
[design]
P = { of = ["loads.push.force.x"], factors = [-1] }
[responses]
y = { type = "displacement", body = "beam", point = "tip", component = "y" }
"""
FREQUENCIES = 'f1 = { type = "frequency" }\nf2 = { type = "frequency", number = 2 }\n'


def save_column(folder: Path, damping: float) -> None:
    """Its reduced model."""
    section = Section(youngs_modulus=12e6, density=100.0, thickness=0.01, width=1.0, damping_stiffness=damping)
    save_beam(folder / "beam.h5", NODES, section, {"tip": 1.0})


def column(folder: Path, force: float, frames: int, responses: str = FREQUENCIES, damping: float = 0.0) -> Scene:
    """Of length, bending stiffness and mass per length 1."""
    save_column(folder, damping)
    (folder / "scene.toml").write_text(SCENE.replace("FRAMES", str(frames)).replace("FORCE", repr(force)) + responses)
    return ffrf.read_scene(folder / "scene.toml")


def beam_matrices(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness, mass and what a unit force along it takes from the stiffness, of n elements, clamped at its first node."""
    h = 1 / n
    K, M, G = (np.zeros((2 * n + 2, 2 * n + 2)) for _ in range(3))
    for e in range(n):
        at = slice(2 * e, 2 * e + 4)
        K[at, at] += np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                               [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]) / h**3  # fmt: skip
        M[at, at] += np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                               [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]) * h / 420  # fmt: skip
        G[at, at] += np.array([[36, 3 * h, -36, 3 * h], [3 * h, 4 * h**2, -3 * h, -h**2],
                               [-36, -3 * h, 36, -3 * h], [3 * h, -h**2, -3 * h, 4 * h**2]]) / (30 * h)  # fmt: skip
    return K[2:, 2:], M[2:, 2:], G[2:, 2:]


def beck(force: float) -> tuple[np.ndarray, np.ndarray]:
    """The two lowest frequencies and their derivatives by the force; it flutters beyond 20.05."""
    K, M, G = beam_matrices(30)
    G[-2, -1] -= 1.0  # the force turns with the tip
    squares, left, right = scipy.linalg.eig(K - force * G, M, left=True, right=True)
    lowest = np.argsort(squares.real)[:2]
    frequencies = np.sqrt(squares[lowest].real) / (2 * np.pi)
    u, w = right[:, lowest], left[:, lowest].conj()
    slopes = -np.sum(w * (G @ u), axis=0) / np.sum(w * (M @ u), axis=0)
    return frequencies, slopes.real / (8 * np.pi**2 * frequencies)


@pytest.mark.parametrize(("force", "frames"), [(15.0, 4), (19.5, 8), (5.0, 16)])
def test_derivatives_of_frequencies_that_are_about_to_merge_are_doubted_by_their_true_size(tmp_path, force, frames):
    run = ffrf.compile(column(tmp_path, force, frames), variables=["P"]).statics(gradients=True)
    parts = np.array([run.gradients[f]["P"] for f in ("f1", "f2")]) / beck(force)[1]
    told = [each.text for each in run.verdict.warnings if each.code == "merging-vibrations"]
    wrong = np.abs(parts - 1) > 0.05
    assert bool(told) == bool(wrong.any()) == (not run.verdict.trusted)
    found = {f: float(part) for f, part in re.findall(r"derivatives of (f\d) are ([0-9.]+) times", "".join(told))}
    assert found == pytest.approx({f: part for f, part, bad in zip(("f1", "f2"), parts, wrong, strict=True) if bad}, rel=0.1)


def test_frequencies_that_are_about_to_merge_are_doubted_by_their_true_size(tmp_path):
    model = ffrf.compile(column(tmp_path, 20.0, 8))
    high = model.modes(count=2).frequencies / beck(20.0)[0] - 1
    text = next(each.text for each in model.modes(count=2).verdict.warnings if each.code == "merging-vibrations")
    low, up = re.findall(r"mode [12] is ([0-9.]+)% too", text)
    assert "too low, mode 2" in text
    assert [-float(low), float(up)] == pytest.approx(100 * high, rel=0.05)


@pytest.mark.parametrize(("force", "frames", "grows"), [(19.9, 4, False), (20.2, 4, True), (25.0, 8, True)])
def test_a_column_that_flutters_is_doubted_whatever_is_asked_for_and_however_few_the_frames_are(tmp_path, force, frames, grows):
    run = ffrf.compile(column(tmp_path, force, frames, responses="")).statics()
    assert run.verdict.trusted == (not grows)
    if force == 25.0:
        assert "exp(4.915 t), with 1.69 cycles" in " ".join(run.verdict.reasons)  # 4.917 and 1.690 by a finer column


@pytest.mark.parametrize(("force", "grows"), [(10.5, False), (11.4, True)])
def test_a_little_damping_inside_makes_it_flutter_sooner(tmp_path, force, grows):
    """From 10.94 on, by Bolotin."""
    run = ffrf.compile(column(tmp_path, force, 8, responses="", damping=1e-4)).statics()
    assert ("unstable-vibration" in run.verdict.codes) == grows == (not run.verdict.trusted)
