"""One setting in one process: its scene, its reduced models, one run, its record."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from toolkit.foundation.errors import ToolkitError
from toolkit.scene.scene import Scene
from toolkit.scene_file.reader import read_scene
from toolkit.sensitivity.certificate.rebuilt_bodies import rebuildable, with_model
from toolkit.sensitivity.result import result
from toolkit.sensitivity.sizes import variable_sizes
from toolkit.studies.identity import hashed
from toolkit.studies.tradeoff.runs.one_run import gradients_once, ready_to_run
from toolkit.studies.tradeoff.settings.frame_axes import framed
from toolkit.studies.tradeoff.settings.record import Record
from toolkit.studies.tradeoff.settings.setting import Setting, with_options
from toolkit.studies.tradeoff.settings.skin_models import build, model_file
from toolkit.studies.tradeoff.settings.store import Store


@dataclass(frozen=True)
class Case:
    """What all settings of a study have in common; small enough to be sent to another process.

    Attributes
    ----------
    path, changes
        The scene's file, and values that replace those in it.
    names
        Design variables; none if no gradients are wanted.
    folder
        Where records and models are kept.
    identity
        `store.fingerprint` of all this.
    """

    path: Path
    changes: dict[str, str]
    names: tuple[str, ...]
    folder: Path
    identity: str

    def scene(self) -> Scene:
        """The scene as it stands."""
        return read_scene(self.path, self.changes)

    @property
    def store(self) -> Store:
        """The records."""
        return Store(self.folder / "records")

    @property
    def models(self) -> Path:
        """Folder of reduced models that were built afresh."""
        return self.folder / "models"

    def key(self, setting: Setting) -> str:
        """Hash of everything that a setting's record follows from."""
        return hashed(self.identity, setting.solver, setting.skin, setting.frames, setting.modes)

    def scene_of(self, setting: Setting) -> Scene:
        """The scene solved by a setting, whose models have been built."""
        scene = with_options(self.scene(), setting.solver)
        for body in model_bodies(scene, setting):
            scene = with_model(scene, body, model_file(self.models, self.identity, body, setting.skin).resolve())
        return framed(scene, setting.frames, setting.modes)


def model_bodies(scene: Scene, setting: Setting) -> list[str]:
    """Bodies whose models a setting builds afresh."""
    return list(rebuildable(scene)) if setting.skin else []


def measure(case: Case, setting: Setting) -> Record:
    """Run a setting once and keep its record; a refusal of the toolkit is kept as what came out."""
    record = Record(key=case.key(setting), labels=setting.labels)
    try:
        record = _run(case, setting, record)
    except ToolkitError as error:
        record = record.model_copy(update={"failure": str(error) or type(error).__name__})
    case.store.keep(record)
    return record


def _run(case: Case, setting: Setting, record: Record) -> Record:
    scene = case.scene()
    for body in model_bodies(scene, setting):
        build(scene, body, setting.skin, model_file(case.models, case.identity, body, setting.skin))
    scene = case.scene_of(setting)
    found, method = gradients_once(ready_to_run(scene, list(case.names)))
    solution = found.solution
    outcome = result(scene, solution, found.values, found.gradients, method, 0.0, 0.0)
    facts: dict[str, Any] = {
        "values": outcome.values,
        "gradients": outcome.gradients,
        "units": outcome.units,
        "sizes": variable_sizes(scene, outcome) if case.names else {},
        "method": method,
        "steps": solution.steps,
        "newton_iterations": solution.newton_iterations,
        "drift": float(solution.drift),
        "coordinates": solution.system.n_q,
        "first": found.seconds,
    }
    return record.model_copy(update=facts)
