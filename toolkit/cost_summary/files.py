"""Bytes that were read of the files of reduced models, and why the rest was not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from toolkit.bodies.model_body import DEPENDENCE, ModelBody
from toolkit.compilation.quantities import pressures_of
from toolkit.cost_summary.asked import asking
from toolkit.cost_summary.line import Line
from toolkit.reduced_model.file import stored_bytes
from toolkit.reduced_model.questions.frozen_basis import RICHER_PARTS
from toolkit.reduced_model.questions.mesh_questions import mesh_record
from toolkit.responses.shape_error import ShapeResponse
from toolkit.responses.stress.stress import model_parameter
from toolkit.system.system import System

UNREAD = {
    "affine": "every parameter has its nominal value, no variable changes one",
    "derivatives": "every parameter has its nominal value, no variable changes one",
    "interfaces": "nothing grips the body",
    "shape": "no response asks for the distance to a target",
    "stress": "places of the stress points, for results files and pictures",
    "outline": "for pictures",
    "interior": "for pictures",
    "elements": "no body of this model has several frames",
    "element_derivatives": "no body of this model has several frames and a parameter that changes",
    "element_affine": "no body of this model has several frames and a parameter that changes",
    "pieces": "for pictures",
    "surface": "for pictures",
    "surface_loads": "no load presses on a surface of the body",
    "piece_loads": "no load presses on a surface of a body with several frames",
    "left_out_shapes": "after a run that asks for stress or strain energy",
    **dict.fromkeys(("sections", "section_derivatives", "section_affine"), "after a run for the checks of beams"),
    "mesh": "for pictures, and after a run for the small-deformation meter",
    **dict.fromkeys(RICHER_PARTS, "no frozen body is off its design, no variable turns its shapes"),
}


def files(system: System) -> dict[str, list[Line]]:
    """Bytes of every group of every file; those that were read are what the program has read of it so far."""
    return {path: groups(system, path) for path in model_paths(system)}


def model_paths(system: System) -> list[str]:
    """Files of the scene's flexible bodies."""
    return list(dict.fromkeys(body.model for body in system.scene.bodies.values() if isinstance(body, ModelBody)))


def groups(system: System, path: str) -> list[Line]:
    """Bytes of every group of one file, and of what surrounds the groups."""
    read, full = system.scene.model(path).bytes_read, system.scene.directory / path
    stored = stored_bytes(full)
    lines = [
        Line(name, size, 0, _reason(system, path, name)) if name in read else Line(name, 0, size, UNREAD.get(name, ""))
        for name, size in stored.items()
    ]
    return [*lines, Line("names, attributes, tables of HDF5", 0, _size(full) - sum(stored.values()), "not counted as read")]


def meshes(system: System) -> dict[str, Any]:
    """File -> stress error of its mesh, for files of which it was estimated."""
    records = {path: mesh_record(system.scene.model(path)) for path in model_paths(system)}
    return {path: record for path, record in records.items() if record}


def bytes_read(system: System) -> int:
    """Bytes of arrays that the program has read of all files of the scene so far."""
    return sum(sum(system.scene.model(path).bytes_read.values()) for path in model_paths(system))


def _reason(system: System, path: str, group: str) -> str:
    scene = system.scene
    bodies = {name: body for name, body in scene.bodies.items() if isinstance(body, ModelBody) and body.model == path}
    if group in DEPENDENCE:
        nominal = scene.model(path).nominal
        asked = [
            each.name
            for each in system.design
            if any(model_parameter(scene, name, path) in nominal for name in bodies for path in each.paths)
        ]
        return f"for {', '.join(asked)}" if asked else "a parameter is off its nominal value"
    if group in RICHER_PARTS:
        return "to judge what frozen shapes lack"
    if group == "shape":
        return f"for {', '.join(name for body in bodies for name in asking(scene, ShapeResponse, body))}"
    if group in ("surface_loads", "piece_loads"):
        return f"for {', '.join(name for name, load in pressures_of(scene).items() if load.body in bodies)}"
    return "equations of motion"


def _size(path: Path) -> int:
    return path.stat().st_size
