"""Whether finished matrices are those of one isotropic material that fills its elements, or of a free body at all.

Whether finished matrices are those of one isotropic material that fills the elements of a mesh.

All displacement-based elements follow a uniform strain exactly, u = eps x at their nodes, whatever their order and integration. So

    u . K u = V eps : C : eps,    sum of the entries of one component of M = rho V,    and their centre is that of the volume,

with the volume V, in the plane times the width, from the elements of the mesh. Without elements V is mass by density, so that the second
equation says nothing, and the first one whether both matrices fit to the material.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isclose, log10
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import ConvexHull, QhullError

from preprocessing.elements.solid_elements import ElementBlock, points_of
from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions, translations
from toolkit.foundation.errors import InputError

UNEQUAL_MATERIAL = 1e-3
"""Relative difference of mass or stiffness that digits in files explain; of curved elements what their integration does is added."""
OFF_CENTRE = 0.02
"""Distance of the two centres, in parts of the extent: masses that are lumped at nodes move it a little, another order of nodes far."""
COARSE = {"triangle": 1, "quad": 1, "tetra": 1, "hexahedron": 1, "wedge": 1, "triangle6": 2, "tetra10": 2}
"""Order of the fewest points by which programs integrate an element; 3 for the others, two points along each axis."""
LARGEST_BULGE = 1.25
"""Largest volume, in parts of what lies between the nodes: a curved edge leaves the straight lines between its three nodes, as of a disk
with eight of them."""
TWO_INTEGRATIONS = 0.005
"""Relative difference of the volumes by which two matrices of curved elements were integrated."""
ELEMENTS_AT_ONCE = 20_000
"""Elements whose maps at all points are in memory at once."""
REMEDY = (
    "Correct [material], give the files that belong to it, or leave [material] out, so that the model has a stiffness_scale and a "
    "mass_scale"
)


@dataclass(frozen=True)
class UniformMaterial:
    """Isotropic material of a whole body, as body.toml describes it."""

    youngs_modulus: float
    density: float
    lame: tuple[float, float] | None  # lambda / E and mu / E; None without Poisson's ratio
    width: float = 1.0  # of plane bodies
    state: str = "space"  # or "plane-stress", "plane-strain"


class Volume(NamedTuple):
    """Volume of elements, or their area in the plane, with its centre."""

    size: float
    centre: np.ndarray  # (d,)
    doubt: float  # relative difference of the size by as few points as programs use
    words: str = "the mesh's elements"  # what has this volume


def volume_of(blocks: Sequence[ElementBlock]) -> Volume:
    """Volume of the elements of a mesh, with its centre."""
    size, coarse, moment = 0.0, 0.0, 0.0
    for block in blocks:
        mapping, (points, weights) = block.geometry.mapping(), points_of(block.kind)
        fewer, their_weights = points_of(block.kind, COARSE.get(block.kind, 3))
        for elements in np.array_split(np.arange(len(block.connectivity)), 1 + len(block.connectivity) // ELEMENTS_AT_ONCE):
            each = np.abs(mapping.detDF(points, elements)) * weights
            size += each.sum()
            moment = moment + np.einsum("aep,ep->a", mapping.F(points, elements), each)
            coarse += (np.abs(mapping.detDF(fewer, elements)) * their_weights).sum()
    return Volume(float(size), np.asarray(moment) / size, float(abs(coarse / size - 1)))


def volume_of_mass(mesh: SolidMesh, scalar_mass: csr_array, material: UniformMaterial) -> Volume:
    """Volume that the mass has at the density of the material, of a body of which only nodes are known.

    Raises
    ------
    InputError
        It is larger than all that lies between the nodes.
    """
    nodal = np.asarray(scalar_mass.sum(axis=1)).ravel()
    mass, across = float(nodal.sum()), " times width" if mesh.dimension == 2 else ""
    size, most = mass / (material.density * material.width), _between(mesh.nodes)
    if not 0 < size <= LARGEST_BULGE * most:
        raise InputError(
            f"the mass matrix has a mass of {mass:g}, which is density times a volume of {size:g}{across}, and all "
            f"nodes lie within {most:g}. {REMEDY}. If the mass is meant, because of point masses for example, set "
            "matrices.mass_differs = true."
        )
    return Volume(size, nodal @ mesh.nodes / mass, TWO_INTEGRATIONS, "a volume of mass by density")


def _between(nodes: np.ndarray) -> float:
    """Volume of all that lies between nodes, in the plane its area; infinite where they lie on a plane or a line."""
    try:
        return float(ConvexHull(nodes).volume)
    except QhullError:
        return inf


def refuse_other_mass(
    mesh: SolidMesh, scalar_mass: csr_array, material: UniformMaterial, volume: Volume, differs: bool = False
) -> None:
    """Refuse a mass matrix (n_nodes, n_nodes) of one component that has another mass than the material in the elements.

    Parameters
    ----------
    scalar_mass : without the concentrated masses of the mesh file, unless it differs
    differs : whether the mass is meant to be another one

    Raises
    ------
    InputError
        It tells both masses, their ratio and the likely reason.
    """
    nodal = np.asarray(scalar_mass.sum(axis=1)).ravel()
    mass, meant = float(nodal.sum()), material.density * material.width * volume.size
    if not differs and not isclose(mass, meant, rel_tol=UNEQUAL_MATERIAL + 2 * volume.doubt):
        points = sum(each.mass for each in mesh.masses)
        _say_other_mass(mass, meant, points, material.density, mesh.dimension)
    if not differs:
        _refuse_other_centre(nodal @ mesh.nodes / mass, volume, mesh.size)


def _refuse_other_centre(centre: np.ndarray, volume: Volume, size: float) -> None:
    """Refuse a mass whose centre is not that of the volume of a body of this extent."""
    if np.abs(centre - volume.centre).max() > OFF_CENTRE * size:
        places = (", ".join(f"{x:g}" for x in place) for place in (centre, volume.centre))
        raise InputError(
            "the mass matrix has its centre at ({}), and the elements of the mesh have theirs at ({}). Give both of one model, with nodes "
            "in one order.".format(*places)
        )


def _say_other_mass(mass: float, meant: float, points: float, density: float, dimension: int) -> None:
    across = " times width" if dimension == 2 else ""
    without = f" without the point masses of {points:g} in the mesh file" if points else ""
    raise InputError(
        f"the mass matrix has a mass of {mass:g}{without}, but density times volume{across} of the mesh is {meant:g}: the ratio is "
        f"{mass / meant:.6g}{_power_of_ten(mass / meant)}, and the elements would have this mass with a density "
        f"of {density * mass / meant:.6g}. {REMEDY}. If the mass is meant, because of point masses for example, set "
        "matrices.mass_differs = true."
    )


def refuse_other_stiffness(mesh: SolidMesh, stiffness: csr_array, material: UniformMaterial, volume: Volume) -> None:
    """Refuse a stiffness matrix whose energies under uniform strains are not those of the material in the elements.

    Raises
    ------
    InputError
        It tells which material they are of, or that they are of no single one.
    """
    strains = uniform_strains(mesh.nodes - volume.centre)
    found = strains.T @ (stiffness @ strains) / (material.width * volume.size)
    by_lambda, by_mu = _forms(mesh.dimension)
    unequal = UNEQUAL_MATERIAL + 2 * volume.doubt
    lame, *_ = np.linalg.lstsq(np.column_stack([by_lambda.ravel(), by_mu.ravel()]), found.ravel(), rcond=None)
    if material.lame is not None:
        meant = material.youngs_modulus * (material.lame[0] * by_lambda + material.lame[1] * by_mu)
        if np.abs(found - meant).max() <= unequal * np.abs(meant).max():
            return
    if (
        np.abs(lame[0] * by_lambda + lame[1] * by_mu - found).max() > unequal * np.abs(found).max()
        or min(lame[1], lame.sum()) <= 0
    ):
        raise InputError(
            "the stiffness matrix has energies under uniform strains that are those of no single isotropic material: it has several "
            "materials, springs, or a material that differs by direction, or nodes and matrices are not of one model. "
            f"{REMEDY}."
        )
    _refuse_material(lame, material, volume)


def _refuse_material(lame: np.ndarray, material: UniformMaterial, volume: Volume) -> None:
    """Refuse the material of body.toml where the matrix is of another one; without Poisson's ratio its modulus decides."""
    states = [material.state] if material.state == "space" or material.lame else ["plane-stress", "plane-strain"]
    found = [_modulus_and_ratio(lame, state) for state in states]
    unequal = UNEQUAL_MATERIAL + 2 * volume.doubt
    if material.lame is None and any(isclose(modulus, material.youngs_modulus, rel_tol=unequal) for modulus, _ in found):
        return
    modulus, ratio = found[0]
    part = modulus / material.youngs_modulus
    own = ""
    if material.lame is not None:
        own = f" and {_modulus_and_ratio(np.array(material.lame, float), material.state)[1]:.6g}"
    raise InputError(
        f"the stiffness matrix is that of a material with Young's modulus {modulus:.6g} and Poisson's ratio {ratio:.6g}, as its energies "
        f"under uniform strains of {volume.words} say, and [material] has {material.youngs_modulus:.6g}{own}: the ratio of the "
        f"moduli is {part:.6g}{_power_of_ten(part)}. {REMEDY}."
    )


def uniform_strains(places: np.ndarray) -> np.ndarray:
    """Nodal coordinates (n, n_strains) of the unit strains at places (n_nodes, d): along each axis, then of each pair of them."""
    d = places.shape[1]
    found = []
    for a, b in _pairs(d):
        moved = np.zeros_like(places)
        moved[:, a] += places[:, b] / 2
        moved[:, b] += places[:, a] / 2
        found.append(moved.ravel())
    return np.column_stack(found)


def _pairs(d: int) -> list[tuple[int, int]]:
    return [(a, a) for a in range(d)] + [(a, b) for a in range(d) for b in range(a + 1, d)]


def _forms(d: int) -> tuple[np.ndarray, np.ndarray]:
    """Matrices that lambda and mu multiply in the elasticity of the unit strains."""
    normal = np.array([a == b for a, b in _pairs(d)], float)
    return np.outer(normal, normal), np.diag(1 + normal)


def _modulus_and_ratio(lame: np.ndarray, state: str) -> tuple[float, float]:
    """Young's modulus and Poisson's ratio of Lame's constants, the first of which is that of the plane in plane stress."""
    first, shear = lame.tolist()
    if state == "plane-stress":
        ratio = first / (first + 2 * shear)
        return 2 * shear * (1 + ratio), ratio
    return shear * (3 * first + 2 * shear) / (first + shear), first / (2 * (first + shear))


def _power_of_ten(ratio: float) -> str:
    """Likely origin of a ratio of 1000 and the like, in words; empty for others."""
    power = log10(ratio) if ratio > 0 else 0.0
    if round(power) and abs(power - round(power)) < UNEQUAL_MATERIAL:
        return f", 10^{round(power)}, as of other units (check `units`, and `scale` in [mesh])"
    return ""


UNEQUAL_MASSES = 1e-9
"""Largest difference, relative to the largest entry, of parts of a mass matrix that should be equal or zero."""
RIGID_MOTION_FORCE = 1e-6
"""Largest force against a rigid motion, relative to those of a motion of the same size of single nodes."""


def refuse_swapped(mesh: SolidMesh, mass: csr_array, stiffness: csr_array) -> None:
    """Refuse swapped matrices: a mass matrix without inertia of translations, while the stiffness matrix resists them.

    Raises
    ------
    InputError
        They are swapped.
    """
    motion = translations(*mesh.nodes.shape)
    resisted = [
        np.abs(matrix @ motion).max() > RIGID_MOTION_FORCE * (abs(matrix) @ np.abs(motion)).max() for matrix in (mass, stiffness)
    ]
    if resisted == [False, True]:
        raise InputError(
            "a motion of the whole body meets no mass, but stiffness: the two files are swapped. Give the mass matrix as mass, and the "
            "stiffness matrix as stiffness."
        )


def scalar_mass(mass: csr_array, d: int) -> csr_array:
    """Mass matrix (n_nodes, n_nodes) of one of d components, which is the same for all.

    Raises
    ------
    InputError
        It is not: the elements are none of displacements alone.
    """
    first, limit, axes = mass[0::d, 0::d], UNEQUAL_MASSES * abs(mass).max(), range(d)
    coupled = max(abs(mass[a::d, b::d]).max() for a in axes for b in axes if a != b)
    if coupled > limit or max(abs(mass[a::d, a::d] - first).max() for a in axes) > limit:
        what = " and ".join(("x", "y") if d == 2 else ("x, y", "z"))
        raise InputError(
            f"the mass matrix treats {what} differently or couples them, as displacement-based solids do not. Export it in the order "
            f"{what} of node 0, {what} of node 1, ..., without rotations, and all of it."
        )
    return first


def without_constant(scalar: csr_array, constant: Mapping[tuple[int, int], csr_array], mesh: SolidMesh) -> csr_array:
    """A scalar mass matrix without concentrated masses M_ab of nodes, which it holds as the exported model does.

    Raises
    ------
    InputError
        There is not more mass than these at a node.
    """
    at_nodes = slice(0, mesh.n, mesh.dimension)
    left = (scalar - constant[0, 0][at_nodes, at_nodes]).tocsr()
    if np.any(left.diagonal() <= 0):
        raise InputError(
            "the mass matrix does not hold the concentrated masses of the mesh file: at a node it has less than these. Export mass and "
            "mesh from one model, or leave the masses out: leave_out in [mesh]."
        )
    return left


def refuse_supports(mesh: SolidMesh, stiffness: csr_array) -> None:
    """Refuse a stiffness matrix that resists rigid motions.

    Raises
    ------
    InputError
        It names the motion.
    """
    centred = rigid_motions(mesh.nodes - mesh.nodes.mean(axis=0))
    names = ("x", "y", "rotation") if mesh.dimension == 2 else ("x", "y", "z", "rotation about x", "about y", "about z")
    for axis, motion in zip(names, centred.T, strict=True):
        force, own = np.abs(stiffness @ motion).max(), (abs(stiffness) @ np.abs(motion)).max()
        if force > RIGID_MOTION_FORCE * own:
            raise InputError(
                f"the stiffness matrix resists a rigid motion ({axis}) by {force / own:.0e} of the forces of its elements. Export it "
                "without supports, with nodes in the same order, and with all displacements of every node."
            )
