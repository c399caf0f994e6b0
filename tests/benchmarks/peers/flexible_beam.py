"""A flexible beam of solid elements on a hinge, pulled by a force at its tip: the same matrices and modes in both programs.

Exudyn applies gravity at the undeformed centre of mass of such a body; a force on the nodes of the tip is the same in both.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import exudyn
import numpy as np
import scipy.linalg
import scipy.sparse
import skfem
from exudyn import itemInterface as items
from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface
from skfem.helpers import dot
from skfem.models.elasticity import lame_parameters, linear_elasticity

import ffrf
from preprocessing import build
from tests.benchmarks.peers import exudyn_runs, our_runs
from tests.benchmarks.peers.contest import Contest
from toolkit.api import space
from toolkit.reduced_model.file import save

END_TIME, STEP, RHO_INF = 0.5, 1e-3, 0.8
MODULUS, POISSON, DENSITY = 2.1e11, 0.3, 7800.0
PULL = -60.0  # N, along z
BODY = f"""units = "m-kg-s"
[matrices]
mass = "mass.npz"
stiffness = "stiffness.npz"
nodes = "nodes.npy"
[material]
youngs_modulus = {MODULUS}
poisson_ratio = {POISSON}
density = {DENSITY}
[clamp]
nodes = {{root}}
[interface_points.tip]
nodes = {{tip}}
[basis]
kind = "eigenmodes"
count = {{modes}}
"""


class Beam(NamedTuple):
    """1 x 0.04 x 0.03 m of steel, of 20 hexahedra with 27 nodes; the two heights keep its frequencies apart."""

    mass: scipy.sparse.csr_matrix
    stiffness: scipy.sparse.csr_matrix
    nodes: np.ndarray  # (369, 3)

    def at(self, x: float) -> np.ndarray:
        """Numbers of the nodes of a cross section."""
        return np.flatnonzero(np.isclose(self.nodes[:, 0], x))

    def modes(self, count: int) -> np.ndarray:
        """Lowest modes of the beam clamped at its root, (3 nodes, count)."""
        free = np.setdiff1d(np.arange(3 * len(self.nodes)), (3 * self.at(0.0)[:, None] + np.arange(3)).ravel())
        shapes = np.zeros((3 * len(self.nodes), count))
        part = np.ix_(free, free)
        pencil = self.stiffness.toarray()[part], self.mass.toarray()[part]
        shapes[free] = scipy.linalg.eigh(*pencil, subset_by_index=(0, count - 1))[1]
        return shapes


@cache
def beam() -> Beam:
    """Its matrices, by scikit-fem."""
    mesh = skfem.MeshHex.init_tensor(np.linspace(0.0, 1.0, 21), np.array([-0.02, 0.02]), np.array([-0.015, 0.015]))
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex2()))
    stiffness = linear_elasticity(*lame_parameters(MODULUS, POISSON)).assemble(basis).tocsr()
    mass = DENSITY * skfem.BilinearForm(lambda u, v, _: dot(u, v)).assemble(basis).tocsr()
    return Beam(mass, stiffness, np.ascontiguousarray(basis.doflocs[:, ::3].T))


def contest(modes: int) -> Contest:
    """Displacement of the tip after half a second, in which the beam falls through more than a quarter of a turn."""
    return Contest(
        name=f"flexible beam in space, {modes} modes",
        quantity="displacement of the tip, m",
        end_time=END_TIME,
        step=STEP,
        ours=our_runs.makers(in_ffrf(modes), END_TIME, RHO_INF, lambda run: np.array([run.values["x"], run.values["z"]])),
        exudyn=exudyn_runs.makers(lambda: in_exudyn(modes), END_TIME, RHO_INF, ["EigenDense"]),
    )


def in_ffrf(modes: int) -> ffrf.Scene:
    """The reduced body on a hinge about y."""
    folder = Path(_FOLDER.name)
    path, parts = folder / f"beam{modes}.toml", beam()
    scipy.sparse.save_npz(folder / "mass.npz", parts.mass)
    scipy.sparse.save_npz(folder / "stiffness.npz", parts.stiffness)
    np.save(folder / "nodes.npy", parts.nodes)
    path.write_text(BODY.format(root=parts.at(0.0).tolist(), tip=parts.at(1.0).tolist(), modes=modes))
    save(build(path), path.with_suffix(".h5"))
    return ffrf.Scene(
        units="m-kg-s",
        dimension=3,
        directory=folder,
        points={
            "O": space.Point(x=0.0, y=0.0, z=0.0),
            "root": space.BodyPoint(body="beam", interface="(frame)"),
            "tip": space.BodyPoint(body="beam", interface="tip"),
        },
        bodies={"beam": space.Flexible(model=f"beam{modes}.h5", frame="moving")},
        joints={"hinge": space.Revolute(bodies=("beam", "ground"), point=("root", "O"), axis=(0.0, 1.0, 0.0))},
        loads={"pull": space.PointForce(body="beam", point="tip", force=(0.0, 0.0, PULL))},
        responses={axis: space.Displacement(body="beam", point="tip", component=axis) for axis in "xz"},
    )


_FOLDER = TemporaryDirectory()


def in_exudyn(modes: int) -> tuple[Any, Callable[[], np.ndarray]]:
    """The reduced body with the hinge on its frame, which is the cheapest way."""
    parts = beam()
    mesh = FEMinterface()
    mesh.nodes, mesh.massMatrix, mesh.stiffnessMatrix = {"Position": parts.nodes}, parts.mass, parts.stiffness
    mesh.modeBasis = {"matrix": parts.modes(modes), "type": "NormalModes"}
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    body = ObjectFFRFreducedOrderInterface(mesh).AddObjectFFRFreducedOrder(system)
    ground = system.AddMarker(items.MarkerBodyRigid(bodyNumber=system.AddObject(items.ObjectGround())))
    frame = system.AddMarker(items.MarkerNodeRigid(nodeNumber=body["nRigidBody"]))
    system.AddObject(items.GenericJoint(markerNumbers=[ground, frame], constrainedAxes=[1, 1, 1, 1, 0, 1]))
    tip = parts.at(1.0)
    face = items.MarkerSuperElementPosition(
        bodyNumber=body["oFFRFreducedOrder"], meshNodeNumbers=tip.tolist(), weightingFactors=[1 / len(tip)] * len(tip)
    )
    system.AddLoad(items.LoadForceVector(markerNumber=system.AddMarker(face), loadVector=[0.0, 0.0, PULL]))
    system.Assemble()

    def displacement() -> np.ndarray:
        assert container is not None  # owns the system
        kind = exudyn.OutputVariableType.Position
        nodes = [system.GetObjectOutputSuperElement(body["oFFRFreducedOrder"], kind, int(node)) for node in tip]
        return (np.mean(nodes, axis=0) - parts.nodes[tip].mean(axis=0))[[0, 2]]

    return system, displacement
