"""The matrices of a solid as polynomials of its parameters: from elements, or finished ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from preprocessing.assembly.assembly import Part, Parts
from preprocessing.assembly.solids.elasticity import SolidMatrices, in_block
from preprocessing.assembly.solids.stress import Rows
from preprocessing.assembly.spatial_invariants import NAMES, SpatialParts
from preprocessing.elements.section import Monomial
from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.spatial_model import PAIRS

PLANE_NAMES = {"m_11": (0, 0), "m_12": (0, 1), "m_22": (1, 1)}
"""Component mass matrices of the plane, and their axes."""

UNEQUAL = 1e-9
"""Largest difference, relative to the largest entry, of parts of a mass matrix that should be equal or zero."""
RESISTED = 1e-6
"""Largest force against a rigid motion, relative to those of a motion of the same size of single nodes."""

QUANTITIES = {
    "youngs_modulus": "stress", "density": "density", "width": "length", "stiffness_scale": "none", "mass_scale": "none",
    "poisson_ratio": "none", "damping_mass": "rate", "damping_stiffness": "time",
}  # fmt: skip
"""Parameters of solids, and what they are, for their units."""


def parts_of(mass: Any, stiffness: Any, stress: Any, inertial: Monomial, elastic: Monomial, stressed: Monomial) -> Parts:
    """Parts from matrices for unit parameters.

    Parameters
    ----------
    mass : sparse (n_nodes, n_nodes), of one component of the displacement
    stiffness, stress : sparse (n, n), (n_stress, n)
    inertial, elastic, stressed : the monomials that these are multiplied by
    """
    dimension = stiffness.shape[0] // mass.shape[0]
    names = PLANE_NAMES if dimension == 2 else dict(zip(NAMES, PAIRS, strict=True))
    blocks = {name: in_block(mass, a, b, dimension) for name, (a, b) in names.items()}
    whole = sum(blocks[name] for name, (a, b) in names.items() if a == b)
    damped = [("damping_mass", inertial, whole), ("damping_stiffness", elastic, stiffness)]
    found = [
        *(Part(inertial, name, block) for name, block in blocks.items()),
        Part(elastic, "stiffness", stiffness),
        *(Part(((name, 1), *factors), "damping", matrix) for name, factors, matrix in damped),
        Part(stressed, "stress", stress),
    ]
    kind = Parts if dimension == 2 else SpatialParts
    return kind(tuple(found), stiffness.shape[0], stress.shape[0])


def element_parts(matrices: SolidMatrices, rows: Rows, lame: tuple[Any, Any]) -> Parts:
    """Of elements: M = rho b M_1, K = E b (lambda/E K_lambda + mu/E K_mu), stress = E (lambda/E ... + mu/E ...); in space without b."""
    stiffness, stress = (lame[0] * first + lame[1] * shear for first, shear in ((matrices.first, matrices.shear), rows))
    width = _width(stiffness.shape[0] // matrices.scalar_mass.shape[0])
    inertial, elastic = (("density", 1), *width), (("youngs_modulus", 1), *width)
    return parts_of(matrices.scalar_mass, stiffness, stress, inertial, elastic, (("youngs_modulus", 1),))


def _width(dimension: int) -> Monomial:
    return (("width", 1),) if dimension == 2 else ()


def finished_parts(mesh: SolidMesh, mass: Any, stiffness: Any, stress: Any, made_with: Mapping[str, float]) -> Parts:
    """Of finished matrices, which are proportional to the material that they were made with, or else to a scale.

    Raises
    ------
    InputError
        The matrices are not those of displacement-based elements, or of a body with supports.
    """
    _refuse_supports(mesh, stiffness)
    scalar = _scalar_mass(mass, mesh.dimension)
    if not made_with:
        scale: Monomial = (("stiffness_scale", 1),)
        return parts_of(scalar, stiffness, stress, (("mass_scale", 1),), scale, scale)
    modulus, density, width = made_with["youngs_modulus"], made_with["density"], made_with.get("width", 1.0)
    inertial, elastic = (("density", 1), *_width(mesh.dimension)), (("youngs_modulus", 1), *_width(mesh.dimension))
    scaled = scalar / (density * width), stiffness / (modulus * width), stress / modulus
    return parts_of(*scaled, inertial, elastic, (("youngs_modulus", 1),))


def _scalar_mass(mass: Any, d: int) -> Any:
    """The mass matrix (n_nodes, n_nodes) of one component, which is that of all."""
    first, limit, axes = mass[0::d, 0::d], UNEQUAL * abs(mass).max(), range(d)
    coupled = max(abs(mass[a::d, b::d]).max() for a in axes for b in axes if a != b)
    if coupled > limit or max(abs(mass[a::d, a::d] - first).max() for a in axes) > limit:
        what = " and ".join(("x", "y") if d == 2 else ("x, y", "z"))
        raise InputError(
            f"the mass matrix treats {what} differently or couples them, as displacement-based solids do not. Export it in the order "
            f"{what} of node 0, {what} of node 1, ..., without rotations, and all of it."
        )
    return first


def _refuse_supports(mesh: SolidMesh, stiffness: Any) -> None:
    centred = rigid_motions(mesh.nodes - mesh.nodes.mean(axis=0))
    names = ("x", "y", "rotation") if mesh.dimension == 2 else ("x", "y", "z", "rotation about x", "about y", "about z")
    for axis, motion in zip(names, centred.T, strict=True):
        force, own = np.abs(stiffness @ motion).max(), (abs(stiffness) @ np.abs(motion)).max()
        if force > RESISTED * own:
            raise InputError(
                f"the stiffness matrix resists a rigid motion ({axis}) by {force / own:.0e} of the forces of its elements. Export it "
                "without supports, with nodes in the same order, and with all displacements of every node."
            )


def parameters_of(material: Mapping[str, float], damping: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """Parameters by which the matrices are polynomials, and their nominal values; without a material they are scales."""
    yield from (material or {"stiffness_scale": 1.0, "mass_scale": 1.0}).items()
    yield from ((f"damping_{name}", value) for name, value in damping.items())
