"""What a reduced model keeps for pictures: fibres of beams as lines, and the surface with its triangles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from preprocessing.elements.beams import SpatialBeam
from preprocessing.elements.section import Monomial, SectionShape, value_of
from preprocessing.reduction.invariants import polynomial_of
from preprocessing.reduction.reduced import ReducedParts
from toolkit.reduced_model.dependence import SparsePolynomial
from toolkit.reduced_model.model import ReducedModel
from toolkit.reduced_model.parts import SURFACE_POSITION, Surface, SurfaceLoad

if TYPE_CHECKING:
    from preprocessing.mesh.faces import BoundaryFaces


def fibre_lines(beams: SpatialBeam, z: np.ndarray, values: Mapping[str, float]) -> Surface:
    """Lines of the fibres for Z = [xi, Psi] (n, 1 + n_f), at the dimensions `values` of the sections."""
    first, triad = beams.first_rows, beams.axes
    position = np.zeros((int(first[-1]), 3, z.shape[1]))
    for each in beams.patches:
        dimensions = {quantity: values[name] for quantity, name in each.patch.parameters.items()}
        for element in each.patch.elements:
            offsets = _offsets(each.shape, dimensions) @ triad[element, 1:]
            ends = ((k, node) for k in range(len(offsets)) for node in beams.connectivity[element])
            for number, (k, node) in enumerate(ends, first[element]):
                position[number] = _moved(z, node, offsets[k])
    return Surface(position, np.zeros((0, 3), int), np.arange(len(position)).reshape(-1, 2))


def fibre_polynomial(beams: SpatialBeam, z: np.ndarray, parameters: list[str]) -> SparsePolynomial:
    """The positions of the ends of the lines as a polynomial of the sizes of the sections, in which they are linear, at a fixed Z."""
    first, triad = beams.first_rows, beams.axes
    found: dict[Monomial, list[tuple[np.ndarray, np.ndarray]]] = {}
    for each in beams.patches:
        shares = _shares(each.shape, each.patch.parameters)
        for element in each.patch.elements:
            ends = ((k, node) for k in range(len(each.shape.fibres)) for node in beams.connectivity[element])
            for number, (k, node) in enumerate(ends, first[element]):
                rows = _rows(z, node)
                for monomial, offsets in shares.items():
                    part = _beside(rows, offsets[k] @ triad[element, 1:]) + (0 if monomial else rows[:3])
                    here = np.flatnonzero(part)
                    found.setdefault(monomial, []).append((number * part.size + here, part.ravel()[here]))
    joined = {monomial: [np.concatenate(each) for each in zip(*entries, strict=True)] for monomial, entries in found.items()}
    return polynomial_of([(monomial, place, value) for monomial, (place, value) in joined.items()], parameters)


def _shares(shape: SectionShape, parameters: Mapping[str, str]) -> dict[Monomial, np.ndarray]:
    """Offsets of all fibres (n_fibres, 2) that are the same at all sizes, and what each size adds per unit, by its parameter."""
    none = dict.fromkeys(parameters, 0.0)
    fixed = _offsets(shape, none)
    slopes = {name: _offsets(shape, {**none, quantity: 1.0}) - fixed for quantity, name in parameters.items()}
    return {(): fixed, **{((name, 1),): slope for name, slope in slopes.items() if slope.any()}}


def _offsets(shape: SectionShape, dimensions: Mapping[str, float]) -> np.ndarray:
    """Offsets y_2, y_3 of every fibre, (n_fibres, 2)."""
    return np.array([[value_of(fibre.second, dimensions), value_of(fibre.third, dimensions)] for fibre in shape.fibres])


def _moved(z: np.ndarray, node: int, offset: np.ndarray) -> np.ndarray:
    """Place (3, 1 + n_f) of a point beside a node, at the offset (3,) when undeformed."""
    rows = _rows(z, node)
    return np.asarray(rows[:3] + _beside(rows, offset))


def _rows(z: np.ndarray, node: int) -> np.ndarray:
    """Displacements and rotations of a node, (6, 1 + n_f)."""
    return z[SpatialBeam.per_node * node : SpatialBeam.per_node * (node + 1)]


def _beside(rows: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """Addition (3, 1 + n_f) to a node's place by an offset (3,), which turns with the node."""
    found = np.cross(rows[3:], offset[:, None], axis=0)
    found[:, 0] += offset
    return found


def surface_of(faces: BoundaryFaces, z: np.ndarray) -> Surface:
    """Surface of a body for Z = [xi, Psi] (n, 1 + n_f): its nodes and triangles."""
    return Surface(z.reshape(-1, 3, z.shape[1])[faces.points], faces.triangles, np.zeros((0, 2), int))


def pressure_on(normals: np.ndarray, z: np.ndarray) -> SurfaceLoad:
    """Unit pressure on a surface: f_a = -sum_k w_ka and L[a, b] = -sum_k w_ka Z_kb for the nodes k.

    Parameters
    ----------
    normals : w (n_nodes, 3), int N_k n dA over the surface, see `BoundaryFaces.normals`; real or complex, as Z
    """
    return SurfaceLoad(-normals.sum(axis=0), -np.einsum("ka,kbj->abj", normals, z.reshape(-1, 3, z.shape[1])))


def with_fibres(model: ReducedModel, found: ReducedParts, beams: SpatialBeam) -> ReducedModel:
    """Reduced model with the fibres of its beams at the nominal design; at others too where the shapes are those of the nominal one."""
    z, values, affine = found.basis.z, found.space.values, found.affine
    if found.basis.constant:
        affine = {**affine, SURFACE_POSITION: fibre_polynomial(beams, z, list(values))}
    return replace(model, surface=fibre_lines(beams, z, values), affine=affine)
