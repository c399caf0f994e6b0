"""The cost summary of a scene: coordinates, terms, file groups and derivative blocks, kept and dropped, why, and what they cost."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from toolkit.cost_summary.asked import derivative_blocks, fields, markers
from toolkit.cost_summary.cost import costs
from toolkit.cost_summary.everything import prepare_everything
from toolkit.cost_summary.files import files, meshes
from toolkit.cost_summary.line import Line
from toolkit.cost_summary.terms import terms
from toolkit.cost_summary.unknowns import coordinates, matrix, rows
from toolkit.scene.scene import Scene, forget_models
from toolkit.sensitivity.preparation import prepare


def cost_summary(scene: Scene, design: list[str], keep_all: bool = False, measured: bool = True) -> dict[str, Any]:
    """Sections of lines, the errors of meshes, then the costs; as in `ffrf inspect SCENE --json`.

    Parameters
    ----------
    design : names of the variables that gradients are wanted by
    keep_all : whether the lines are those of the scene with everything put back; the costs are of both
    measured : whether to measure the time of a step too, by running the scene

    Raises
    ------
    InputError, ModelFileError
        The scene cannot be compiled.
    """
    forget_models()
    system = prepare_everything(scene) if keep_all else prepare(scene, design)
    sections: dict[str, list[Line]] = {
        "coordinates": coordinates(system),
        "constraint rows": rows(system),
        "terms (entries)": terms(system),
        "derivative blocks (rows of the residual)": derivative_blocks(system, scene),
        "fields (points)": fields(system),
        "markers": markers(system),
        "matrix (entries)": matrix(system),
        **{f"bytes of {path}": lines for path, lines in files(system).items()},
    }
    found: dict[str, Any] = {name: [line._asdict() for line in lines] for name, lines in sections.items()}
    return {**found, "meshes": meshes(system), "cost": [asdict(each) for each in costs(scene, design, measured)]}
