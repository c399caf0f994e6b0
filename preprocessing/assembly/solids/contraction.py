"""The contractions of theory section 1 for a solid in the plane or in space, by the dimension of its mesh."""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

from preprocessing.assembly import invariants, spatial_invariants
from preprocessing.mesh.solid_mesh import SolidMesh, translations


class Contractions(NamedTuple):
    """Functions of the same meaning in both dimensions."""

    contract: Any  # (matrices, z) -> invariants
    contract_derivative: Any  # (matrices, d_matrices, z, d_z=) -> invariants
    polynomials: Any  # (parts, parameters, z) -> item -> polynomial


def contractions(mesh: SolidMesh) -> Contractions:
    """Those for bodies of the mesh's dimension, whose nodes have displacements only."""
    if mesh.dimension == 2:
        plane = (invariants.contract, invariants.contract_derivative, invariants.polynomials)
        return Contractions(*(partial(each, per_node=2) for each in plane))
    spatial = (spatial_invariants.contract, spatial_invariants.contract_derivative, spatial_invariants.polynomials)
    return Contractions(*(partial(each, translations=translations(len(mesh.nodes), 3)) for each in spatial))
