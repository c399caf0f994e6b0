"""The good files that are spoilt, and the bounded process in which they are used."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from toolkit.analyses.sensitivity.direct import direct
from toolkit.files.results_file import save_results
from toolkit.files.scene_reader import read_scene
from toolkit.reduced_model.dependence import Derivatives
from toolkit.reduced_model.file import save
from toolkit.reduced_model.model import ReducedModel, Shape

ROOT = Path(__file__).parents[2]
SCENE = """
units = "m-kg-s"
points = { root = { body = "beam", interface = "root" }, tip = { body = "beam", interface = "tip" } }
bodies = { beam = { type = "flexible", model = "MODEL", frame = "moving" } }
joints = { clamp = { type = "rigid", bodies = ["beam", "ground"], point = "root" } }
loads = { pull = { type = "point-force", body = "beam", point = "tip", force = [0.0, 1.0] } }
responses = { stress = { type = "max-stress", body = "beam" }, shape = { type = "shape-rms", body = "beam" } }
solver = { end_time = 0.02, step = 0.01, load_steps = 2 }
"""
MOST_SECONDS, MOST_MEMORY = 150, 2000  # of processor, and MB; a batch takes some 10 s and 300 MB


def beam() -> ReducedModel:
    """A small model that has all parts."""
    model = polygon_beam(np.array([[0, 0], [0.5, 0.1], [1.0, 0]]), Section(2e11, 7800.0, 0.02, 0.05), {"root": 0.0, "tip": 0.9})
    positions = model.interfaces["tip"].position[:1]
    moving_target = {"shape.target": Derivatives(np.array([2, 2]), np.array([0, 1]), np.array([0.1, -0.2]))}
    shape = Shape(positions, positions[:, :, 0] + 0.01, np.array([0.9]))
    return replace(model, shape=shape, derivatives=moving_target)


def good_model(folder: Path) -> None:
    """The model in the form in which it is saved."""
    save(beam(), folder / "good.h5")
    (folder / "scene.toml").write_text(SCENE.replace("MODEL", "case.h5"))


def good_results(folder: Path) -> None:
    """Results of a run of that model."""
    save(beam(), folder / "model.h5")
    (folder / "scene.toml").write_text(SCENE.replace("MODEL", "model.h5"))
    save_results(direct(read_scene(folder / "scene.toml"), ["bodies.beam.thickness"], "transient"), folder / "good.h5", SCENE)


PREPARED = {"model": good_model, "results": good_results}


def limited() -> None:
    """A hang ends the process."""
    resource.setrlimit(resource.RLIMIT_CPU, (MOST_SECONDS, MOST_SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def batch(folder: Path, kind: str, *wanted: int) -> tuple[list[str], int]:
    """Outcomes of all cases in a process of their own, and the most memory in MB that it took."""
    PREPARED[kind](folder)
    os.mkfifo(folder / "pipe")  # whoever opens it waits for ever
    command = [sys.executable, "-m", "tests.fuzz.hdf5_batch", str(folder), kind, *map(str, wanted)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, preexec_fn=limited, check=False)
    lines = done.stdout.splitlines()
    assert done.returncode == 0, (lines[-1:], done.stderr[-2000:])
    return lines[:-1], int(lines[-1].split()[1])
