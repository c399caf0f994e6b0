"""A time series for ParaView: the deformed flexible bodies with stress and its derivatives, and the rigid bodies as lines."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pyvista

from toolkit.render.configuration import Configuration
from toolkit.render.look import choose_look
from toolkit.render.parts import line, skin
from toolkit.render.skin_shape import drawn_model, fibre_values, skin_shape
from toolkit.replaced_file import replaced
from toolkit.responses.stress import stress_field
from toolkit.results.csv_tables import safe_name
from toolkit.solution import Solution
from toolkit.units import unit


def export_paraview(solution: Solution, directory: str | Path) -> Path:
    """Write one PVD file, to be opened in ParaView, and the VTP files that it lists.

    Every flexible body with a mesh is a band as thick as it is (2 % of the scene if its thickness is unknown), with point data
    "stress in <unit>" and "stress by <variable>". Rigid bodies are lines.

    Returns
    -------
    path of `results.pvd` in the folder, which is made if it does not exist
    """
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    look = choose_look(solution, range(len(solution.times)))
    fields = {body: stress_field(solution, body) for body in look.thickness}
    entries: list[tuple[float, str, str]] = []
    digits = len(str(solution.steps))
    for step, time in enumerate(solution.times):
        moment = Configuration(solution, step)
        meshes = {body: _band(moment, body, look.thickness[body] or look.extent / 50, *fields[body]) for body in look.thickness}
        meshes["mechanism"] = _mechanism(moment)
        for name, mesh in meshes.items():
            if mesh is not None:
                file = f"{safe_name(name)}_{step:0{digits}}.vtp"
                with replaced(directory / file) as temporary:
                    mesh.save(temporary)
                entries.append((float(time), name, file))
    path = directory / "results.pvd"
    with replaced(path) as temporary:
        _collection(entries).write(temporary, encoding="utf-8", xml_declaration=True)
    return path


def _band(moment: Configuration, body: str, thickness: float, stress: np.ndarray, dstress: np.ndarray) -> Any:
    shape, label = skin_shape(moment, body), f"stress in {unit(moment.scene.units, 'stress')}"
    if shape is None:
        return None
    mesh = skin(shape, thickness, label, 0.0)
    for x, variable in enumerate(moment.solution.system.design.names):
        values = fibre_values(drawn_model(moment, body), dstress[moment.step, :, x])
        mesh.point_data[f"stress by {variable}"] = np.repeat(values.ravel(), 2)
    return mesh


def _mechanism(moment: Configuration) -> Any:
    lines = [*(ends for body in moment.scene.bodies for ends in moment.segments(body)), *moment.links()]
    return pyvista.PolyData().append_polydata(*map(line, lines)) if lines else None


def _collection(entries: list[tuple[float, str, str]]) -> ElementTree.ElementTree:
    """The list of files by time, as ParaView reads it."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    parts = list(dict.fromkeys(name for _, name, _ in entries))
    for time, name, file in entries:
        ElementTree.SubElement(collection, "DataSet", timestep=repr(time), part=str(parts.index(name)), name=name, file=file)
    return ElementTree.ElementTree(root)
