"""The reduced model of a beam along any polygon: what a linkage with flexible rods, or a rotor blade, is made of."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict

import numpy as np

from preprocessing.assembly import Rayleigh, assemble, derivative, matrices_at
from preprocessing.build import QUANTITIES, WRITER_VERSION
from preprocessing.interface import interface_point
from preprocessing.invariants import contract, contract_derivative, nonzero, polynomials
from preprocessing.mesh import CurveMesh
from preprocessing.reduction import tangent_frame
from preprocessing.section import PARAMETERS, Section
from preprocessing.stress import stress_points
from toolkit.errors import InputError
from toolkit.reduced_model import Mesh, ReducedModel
from toolkit.units import unit


def polygon_beam(
    nodes: np.ndarray, section: Section, interfaces: Mapping[str, float], damping: Rayleigh | None = None, units: str = "m-kg-s"
) -> ReducedModel:
    """A beam along a polygon, one Euler-Bernoulli element per side, its frame tied to the first node.

    Parameters
    ----------
    nodes : (n_nodes, 2) corners of the polygon in the body's frame
    section : modulus, density, thickness in the plane and width across it, in the named system of units
    interfaces : name -> arc length along the polygon where joints and loads may grip
    damping : Rayleigh factors; none by default
    units : "m-kg-s" or "mm-t-s"

    Raises
    ------
    InputError
        Fewer than two nodes, two neighbours at one place, an interface point off the beam, or unknown units.
    """
    nodes, damping = np.asarray(nodes, float), damping or Rayleigh()
    mesh, arc_lengths = _mesh(nodes)
    parts = assemble(mesh, damping)
    basis, matrices = tangent_frame(nodes, 0, "the first node"), matrices_at(parts, section)
    rates = {name: contract_derivative(matrices, derivative(parts, section, name), basis.z) for name in PARAMETERS}
    inputs = repr((nodes.tolist(), asdict(section), dict(interfaces), asdict(damping), units, WRITER_VERSION))
    return ReducedModel(
        dimension=2,
        units=units,
        reference_condition=basis.reference_condition,
        basis=basis.description,
        nominal={name: float(np.real(getattr(section, name))) for name in PARAMETERS},
        nominal_units={name: unit(units, quantity) for name, quantity in QUANTITIES.items()},
        input_hash=hashlib.sha256(inputs.encode()).hexdigest(),
        writers={"ffrf-toolkit": WRITER_VERSION, "numpy": np.__version__},
        invariants=contract(matrices, basis.z),
        derivatives={name: nonzero(rate) for name, rate in rates.items()},
        affine=polynomials(parts, section, basis.z),
        interfaces={name: interface_point(mesh, arc_lengths, basis.z, s) for name, s in interfaces.items()},
        stress=stress_points(len(mesh.connectivity)),
        mesh=Mesh(nodes, mesh.connectivity, basis.z, nodes, np.zeros((0, 2))),
    )


def _mesh(nodes: np.ndarray) -> tuple[CurveMesh, np.ndarray]:
    """Elements from node to node, and the arc lengths (n_nodes,) of the nodes."""
    if nodes.ndim != 2 or nodes.shape[1] != 2 or len(nodes) < 2 or not np.all(np.isfinite(nodes)):
        raise InputError(f"a beam needs at least two finite nodes (x, y); got an array of shape {nodes.shape}.")
    sides = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    if sides.min() <= 1e-12 * sides.sum():
        raise InputError(f"nodes {sides.argmin()} and {sides.argmin() + 1} of the beam coincide; leave one out.")
    numbers = np.arange(len(nodes))
    return CurveMesh(nodes, np.column_stack([numbers[:-1], numbers[1:]])), np.append(0.0, np.cumsum(sides))
