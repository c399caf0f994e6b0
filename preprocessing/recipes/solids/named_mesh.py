"""The mesh of a body.toml, with its regions: the nodes of the clamp and of interface points, pressure surfaces, motions of the nodes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from preprocessing.basis.solids.ties import Tie, tie
from preprocessing.input.at_key import at_key
from preprocessing.mesh.faces import BoundaryFaces, faces_of
from preprocessing.mesh.matrix_file import read_nodes
from preprocessing.mesh.mesh_file import read_mesh
from preprocessing.mesh.node_motion import read_motion
from preprocessing.mesh.outline import outline_of
from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions
from preprocessing.recipes.solids.body_file import BodyFile
from preprocessing.recipes.solids.node_sets import faces_in, nodes_in, spread_of
from toolkit.foundation.errors import InputError

AT_ONE_PLACE = 1e-6
"""Distance of clamped nodes, in parts of the body's extent, below which they leave the body free to turn."""


@dataclass(frozen=True, eq=False)
class NamedMesh:
    """Mesh that body.toml names, and the nodes of its regions, chosen before shape variables move it."""

    path: Path
    file: BodyFile
    mesh: SolidMesh
    boundary: Any  # `Boundary`; None without elements
    clamped: np.ndarray
    tied: Mapping[str, np.ndarray]  # interface point -> nodes
    surfaces: Mapping[str, BoundaryFaces]  # pressure surfaces
    motions: Mapping[str, np.ndarray]  # shape variable -> displacement of the nodes per unit of it, (n_nodes, d)

    def ties(self, nodes: np.ndarray) -> dict[str, Tie]:
        """Interface points, with the nodes at (n_nodes, d), real or complex for a complex step.

        Raises
        ------
        InputError
            The nodes of a point tell no rotation, see `ties.tie`.
        """
        found, mesh = {}, replace(self.mesh, nodes=nodes)
        boundary = self.boundary and replace(self.boundary, nodes=nodes)
        for name, region in self.file.interface_points.items():
            with at_key(self.path, f"interface_points.{name}"):
                members = self.tied[name]
                found[name] = tie(mesh, members, spread_of(mesh, boundary, members), region.at, region.tie == "rigid")
        return found


def named_mesh(path: Path, file: BodyFile) -> NamedMesh:
    """Mesh or nodes that body.toml names, with everything that is named on them.

    Raises
    ------
    InputError
        Names the file, the key and what is wrong there.
    """
    unmoved, mesh, motions = _mesh(path, file)
    _refuse_other_dimension(path, file, mesh)
    with at_key(path, "mesh.file"):
        boundary = _boundary(mesh)
    surfaces = {}
    for name, region in file.pressure_surfaces.items():
        with at_key(path, f"pressure_surfaces.{name}"):
            surfaces[name] = faces_in(unmoved, boundary, region)
    return NamedMesh(path, file, mesh, boundary, _clamped(path, file, unmoved), _tied(path, file, unmoved), surfaces, motions)


def _mesh(path: Path, file: BodyFile) -> tuple[SolidMesh, SolidMesh, dict[str, np.ndarray]]:
    """The mesh of the file, the mesh at the values of the shape variables, and the motion of its nodes by each of them."""
    if file.mesh is None:
        with at_key(path, "matrices.nodes"):
            mesh = SolidMesh(read_nodes(path.parent / str(file.matrices and file.matrices.nodes)))
            return mesh, mesh, {}
    with at_key(path, "mesh.file"):
        unmoved = mesh = read_mesh(path.parent / file.mesh.file, file.mesh.scale, file.mesh.leave_out)
    motions = {}
    for name, variable in file.shape_variables.items():
        with at_key(path, f"shape_variables.{name}"):
            if mesh.dimension == 2:
                raise InputError(
                    "the nodes of plane meshes cannot be moved by variables. Leave [shape_variables] out, or mesh a volume."
                )
            if name in ("poisson_ratio", "youngs_modulus", "density", "damping_mass", "damping_stiffness"):
                raise InputError("this is the name of a parameter of the material. Take another one.")
            motions[name] = read_motion(path.parent / variable.field, mesh, file.mesh.scale)
            mesh = mesh.moved(variable.value * motions[name])
    return unmoved, mesh, motions


def _boundary(mesh: SolidMesh) -> Any:
    if not mesh.blocks:
        return None
    return outline_of(mesh.nodes, mesh.blocks) if mesh.dimension == 2 else faces_of(mesh.nodes, mesh.blocks)


def _refuse_other_dimension(path: Path, file: BodyFile, mesh: SolidMesh) -> None:
    """Refuse keys that bodies in the plane, or in space, do not have or need."""
    plane = mesh.dimension == 2
    if plane and file.material is not None and file.section is None:
        with at_key(path, "section"):
            raise InputError("[material] of a plane body needs [section] with width. Add it.")
    wrong = {
        "section": not plane and file.section is not None,
        "material.state": not plane and file.material is not None and file.material.state is not None,
        "pressure_surfaces": plane and bool(file.pressure_surfaces),
    }
    for key, given in wrong.items():
        if given:
            with at_key(path, key):
                raise InputError(
                    f"this body is {'plane' if plane else 'spatial'}, as its nodes and elements are, and such bodies have none. "
                    f"Leave it out, or give {'a mesh of the volume' if plane else 'nodes and elements in the plane'}."
                )


def _tied(path: Path, file: BodyFile, mesh: SolidMesh) -> dict[str, np.ndarray]:
    """Nodes of every interface point."""
    tied = {}
    for name, region in file.interface_points.items():
        with at_key(path, f"interface_points.{name}"):
            tied[name] = nodes_in(mesh, region)
    return tied


def _clamped(path: Path, file: BodyFile, mesh: SolidMesh) -> np.ndarray:
    """Numbers of the clamped nodes, which leave no rigid motion."""
    if file.clamp is None:
        return np.zeros(0, int)
    with at_key(path, "clamp"):
        nodes = nodes_in(mesh, file.clamp)
        held = rigid_motions((mesh.nodes[nodes] - mesh.nodes[nodes[0]]) / mesh.size)
        if np.linalg.eigvalsh(held.T @ held)[0] < AT_ONE_PLACE**2:
            where, apart = ("at one place", "edge") if mesh.dimension == 2 else ("at one place or on one line", "face")
            raise InputError(
                f"the clamp on {file.clamp.words} holds {len(nodes)} node{'s' * (len(nodes) > 1)} {where}, and the body can still turn "
                f"about it. Clamp nodes that are apart, for example a whole {apart}."
            )
        return nodes
