"""The reduced model of a beam along any polygon: what a linkage with flexible rods, or a rotor blade, is made of."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from dataclasses import asdict

import numpy as np

from preprocessing.basis.basis_choice import BasisChoice
from preprocessing.discretisation.discretisation import DesignSpace, Discretisation
from preprocessing.elements.kinds.beams import PlanarBeam
from preprocessing.elements.patches import distribute
from preprocessing.elements.section import Section
from preprocessing.mesh.curve_mesh import CurveMesh
from preprocessing.recipes.recipe import WRITER_VERSION
from preprocessing.reduction.reduced import reduce
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import Mesh, ReducedModel

FULL = BasisChoice("full")


LATER = ("chord", "spin_stiffening", "beside_frozen")
"""Choices that the first models did not have: where they are not made the hash is theirs."""


def polygon_beam(
    nodes: np.ndarray,
    section: Section,
    interfaces: Mapping[str, float],
    units: str = "m-kg-s",
    separate: Collection[str] = (),
    basis: BasisChoice = FULL,
    rotary_inertia: bool = True,
) -> ReducedModel:
    """Beam along a polygon, one Euler-Bernoulli element per side.

    Its frame is tied to the first node or, by the basis, to a chord.

    Parameters
    ----------
    nodes : (n_nodes, 2) corners of the polygon in the body's frame
    section : modulus, density, thickness in the plane, width across it and Rayleigh damping, in the named system of units
    interfaces : name -> arc length along the polygon where joints and loads may grip
    units : "m-kg-s" or "mm-t-s"
    separate : quantities of the section that every element has of its own, for example ("thickness",)
    basis : what the elastic coordinates are; all nodal coordinates by default
    rotary_inertia : of the section, m t^2 / 12; without it the mass lies on the middle line

    Raises
    ------
    InputError
        A quantity of the section that is not positive, fewer than two nodes, two neighbours at one place, an interface point off the beam,
        unknown units, or an impossible basis.
    """
    for name, value in asdict(section).items():
        if not np.all(np.real(value) >= 0) or (not name.startswith("damping") and not np.all(np.real(value) > 0)):
            raise InputError(f"{name} = {value} of the section must be {'zero or ' * name.startswith('damping')}positive.")
    nodes = np.asarray(nodes, float)
    mesh, arc_lengths = _mesh(nodes)
    parameters = distribute(asdict(section), {}, separate, len(mesh.connectivity))
    beams = PlanarBeam(mesh.nodes, mesh.connectivity, parameters.patches, rotary_inertia=rotary_inertia)
    discrete = Discretisation(beams, interfaces, arc_lengths)
    space = DesignSpace(parameters.values, parameters.quantities, frozenset(parameters.values), lambda _: discrete)
    found = reduce(space, basis, 0, "the first node")
    chosen = {key: value for key, value in asdict(basis).items() if key not in LATER or value}
    inputs = repr((nodes.tolist(), asdict(section), dict(interfaces), units, sorted(separate), chosen, WRITER_VERSION))
    inputs += ", rotary inertia" if rotary_inertia else ""  # models of files that had no such key keep their hash
    return ReducedModel(
        **found.fields(units),
        input_hash=hashlib.sha256(inputs.encode()).hexdigest(),
        writers={"ffrf-toolkit": WRITER_VERSION, "numpy": np.__version__},
        mesh=Mesh(nodes, mesh.connectivity, found.basis.z, nodes, np.zeros((0, 2))),
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
