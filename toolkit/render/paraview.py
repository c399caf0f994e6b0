"""A time series for ParaView: the deformed flexible bodies with stress and its derivatives, and the rigid bodies as lines."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import TypeAlias
from xml.etree import ElementTree

import numpy as np
import pyvista
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

from toolkit.foundation.files.safe_files import own_set, refuse_foreign, safe_name, write_whole
from toolkit.foundation.units import unit
from toolkit.render.plane.configuration import Configuration, SkinShape, drawn_model, fibre_values, skin_shape, solid_shape
from toolkit.render.plane.look import choose_look
from toolkit.render.space import parts
from toolkit.render.space.configuration import SpatialConfiguration, at_points, body_shape, has_shape
from toolkit.responses.stress import point_stress, stress_field
from toolkit.scene.space import PLANE, SPACE
from toolkit.system.solution import Solution, flexible_body


def mechanism(moment: Configuration | SpatialConfiguration, but: Collection[str] = ()) -> pyvista.PolyData | None:
    """Rigid bodies and links of a configuration in the plane or in space as lines, or None; without bodies that are shown already."""
    lines = [*moment.rods(but), *map(moment.ends, moment.links()), *moment.wheels()]
    return pyvista.PolyData().append_polydata(*(pyvista.lines_from_points(lifted(ends)) for ends in lines)) if lines else None


def lifted(points: np.ndarray) -> np.ndarray:
    """Points (n, 2) of the plane in space, (n, 3); points of space stay."""
    return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))]).astype(float)


Meshes: TypeAlias = dict[str, pyvista.PolyData | None]
"""Meshes of one step by name; None of a body that this step draws otherwise."""
COMPONENTS = {"XX": 0, "YY": 1, "ZZ": 2, "XY": 5, "YZ": 3, "XZ": 4}
"""Components of a symmetric tensor in the order of VTK -> their place in ours, xx, yy, zz, yz, xz, xy."""


def add_stress(mesh: pyvista.PolyData, components: np.ndarray, label: str) -> None:
    """Give a mesh six components (n, 6) in the body's own axes, and von Mises' stress of these."""
    mesh.point_data[f"von Mises {label}"] = point_stress(components)
    mesh.point_data[label] = components[:, list(COMPONENTS.values())]
    array = mesh.GetPointData().GetArray(label)
    for place, name in enumerate(COMPONENTS):
        array.SetComponentName(place, name)


def spatial_meshes(solution: Solution) -> Callable[[int], Meshes]:
    """Step -> meshes by name.

    Every flexible body with a surface is that surface, with the lines of beams, and has as point data "displacement in <unit>" from the
    undeformed configuration; of a solid "von Mises stress in <unit>" and "stress in <unit>", six components in the body's own axes; of
    beams "stress in <unit>" of the fibre; and where the run has derivatives, "<the one stress> by <variable>".
    """
    scene, start = solution.system.scene, SpatialConfiguration.undeformed(solution)
    bodies = {body: body_shape(start, body).points for body in start.flexible() if has_shape(scene, body)}
    design = solution.system.design.names
    rates = {body: stress_field(solution, body)[1] for body in bodies} if design and solution.dq.shape[-1] else {}

    def at(step: int) -> Meshes:
        moment = SpatialConfiguration(solution, step)
        found = {body: _surface(moment, body, points) for body, points in bodies.items()}
        for body, by in rates.items():
            surface = scene.model(flexible_body(scene, body).model, "surface").surface
            assert surface is not None
            for x, variable in enumerate(design):
                found[body].point_data[f"{_name(found[body])} by {variable}"] = at_points(surface, by[step, :, x])
        return found | {"mechanism": mechanism(moment)}

    return at


def _name(mesh: pyvista.PolyData) -> str:
    return "von Mises stress" if any(name.startswith("von Mises") for name in mesh.point_data) else "stress"


def _surface(moment: SpatialConfiguration, body: str, undeformed: np.ndarray) -> pyvista.PolyData:
    shape, units = body_shape(moment, body), moment.scene.units
    mesh, label = parts.whole(shape), f"stress in {unit(units, 'stress')}"
    mesh.point_data[f"displacement in {unit(units, 'length')}"] = shape.points - undeformed
    if shape.stress.shape[1] == 1:
        mesh.point_data[label] = shape.stress[:, 0]
    else:
        add_stress(mesh, shape.stress, label)
    return mesh


def plane_solid(moment: Configuration, body: str) -> pyvista.PolyData | None:
    """Section of a plane solid with point data "von Mises stress in <unit>" and "stress in <unit>", or None.

    The stress has six components in the body's own axes.

    None where its model does not tell the stress inside.
    """
    shape = solid_shape(moment, body)
    if shape is None or shape.inside is None:
        return None
    corners = shape.inside.triangles
    faces = np.column_stack([np.full(len(corners), 3), corners])
    mesh = pyvista.PolyData(lifted(shape.inside.points), faces=faces.ravel())
    add_stress(mesh, shape.inside.components, f"stress in {unit(moment.scene.units, 'stress')}")
    return mesh


def export_paraview(solution: Solution, directory: str | Path) -> Path:
    """Write one PVD file, to be opened in ParaView, and the VTP files that it lists.

    Every flexible body with a mesh is a band as thick as it is (2 % of the scene if its thickness is unknown), with point data
    "stress in <unit>" and "stress by <variable>"; a meshed one is its section, see `plane_solid`. Rigid bodies are lines. In space it is
    its surface, see `spatial_meshes`.

    Returns
    -------
    path of `results.pvd` in the folder, which is made if it does not exist
    """
    return write_series(solution, directory, _MESHES[solution.system.scene.space](solution))


def write_series(solution: Solution, directory: str | Path, meshes_at: Callable[[int], Meshes]) -> Path:
    """Write the meshes of every step, name -> mesh or None, and the PVD file that lists them by time; returns its path.

    Raises
    ------
    InputError
        There are files of these names that ffrf has not written.
    """
    directory = Path(directory)
    entries: list[tuple[float, str, str]] = []
    digits = len(str(solution.steps))
    parts = [safe_name(name) for name in meshes_at(0)]
    names = ["results.pvd", *(f"{part}_{step:0{digits}}.vtp" for part in parts for step in range(len(solution.times)))]
    refuse_foreign(directory, names)
    path = directory / "results.pvd"
    with own_set(directory, names, instead_of=["*_*.vtp"]):
        for step, time in enumerate(solution.times):
            for name, mesh in meshes_at(step).items():
                if mesh is not None:
                    file = f"{safe_name(name)}_{step:0{digits}}.vtp"
                    write_whole(directory / file, _vtp(mesh))
                    entries.append((float(time), name, file))
        write_whole(path, ElementTree.tostring(_collection(entries), encoding="utf-8", xml_declaration=True))
    return path


def _vtp(mesh: pyvista.PolyData) -> bytes:
    """The file of a mesh, built in memory: VTK says nothing to Python about a disk that is full."""
    writer = vtkXMLPolyDataWriter()
    writer.SetInputDataObject(mesh)
    writer.SetDataModeToBinary()
    writer.SetWriteToOutputString(True)
    writer.Write()
    return writer.GetOutputString().encode()


def _meshes(solution: Solution) -> Callable[[int], Meshes]:
    look = choose_look(solution, range(len(solution.times)))
    fields = {body: stress_field(solution, body) for body in look.thickness}

    def at(step: int) -> Meshes:
        moment = Configuration(solution, step)
        thick = {body: true or look.extent / 50 for body, true in look.thickness.items()}
        bands = {body: _band(moment, body, thick[body], *fields[body]) for body in thick}
        solids = {body: plane_solid(moment, body) for body in look.solids}
        drawn = [body for body, mesh in solids.items() if mesh is not None]
        return bands | solids | {"mechanism": mechanism(moment, drawn)}

    return at


def _band(moment: Configuration, body: str, thickness: float, stress: np.ndarray, dstress: np.ndarray) -> pyvista.PolyData | None:
    shape, label = skin_shape(moment, body), f"stress in {unit(moment.scene.units, 'stress')}"
    if shape is None:
        return None
    mesh = skin_mesh(shape, thickness, label)
    for x, variable in enumerate(moment.solution.system.design.names):
        values = fibre_values(drawn_model(moment, body), dstress[moment.step, :, x])
        mesh.point_data[f"stress by {variable}"] = np.repeat(values.ravel(), 2)
    return mesh


def _collection(entries: list[tuple[float, str, str]]) -> ElementTree.Element:
    """The list of files by time, as ParaView reads it."""
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    collection = ElementTree.SubElement(root, "Collection")
    parts = list(dict.fromkeys(name for _, name, _ in entries))
    for time, name, file in entries:
        ElementTree.SubElement(collection, "DataSet", timestep=repr(time), part=str(parts.index(name)), name=name, file=file)
    return root


def skin_mesh(shape: SkinShape, thickness: float, name: str) -> pyvista.PolyData:
    """The skin as two bands, middle line to outer and to inner fibre, each with the stress of its fibre as point data of that name."""
    fibres = shape.fibres(thickness)
    edges = np.stack([fibres, np.broadcast_to(shape.line[:, :, None], fibres.shape)], axis=3)  # (n_e, points, fibre, edge, 2)
    n = np.arange(edges[..., 0].size).reshape(edges.shape[:4])
    quads = np.stack([n[:, :-1, :, 0], n[:, 1:, :, 0], n[:, 1:, :, 1], n[:, :-1, :, 1]], axis=-1).reshape(-1, 4)
    faces = np.column_stack([np.full(len(quads), 4), quads])
    mesh = pyvista.PolyData(lifted(edges.reshape(-1, 2)), faces=faces.ravel())
    mesh.point_data[name] = np.repeat(shape.stress.ravel(), 2)
    return mesh


_MESHES = {PLANE: _meshes, SPACE: spatial_meshes}
