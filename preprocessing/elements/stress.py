"""Stress in solids: its operator along the boundary or in elements, its recovery, and how far it is from the truth.

Rows of the stress operator: along the boundary or components in the elements of the plane, all components on a surface in space.

With the strain eps of the displacements and Lame's constants, for the unit vectors a and b,

    a . sigma b = lambda (a . b) tr eps + 2 mu a . eps b

On a free boundary in the plane the stress along it is the only one there is. At a node of a surface in space it is the mean of the
elements that meet there, each at that node.

Stress recovered from finite elements: a smooth field that is nearer to the true one than what it is made of.

Round every corner v of the elements a polynomial P_v is fitted to the stress of the elements that meet there, at points where it is most
exact (Zienkiewicz and Zhu, Int. J. Numer. Meth. Engng 33, 1331, 1992). Between the corners the polynomials are mixed by the shape
functions lambda_v of straight elements, which sum up to one:

    sigma*(x) = sum_v lambda_v(x) P_v(x)

A patch whose points leave a term open, as at the corner of a body, takes in the elements round it if these tell it.

In the energy norm, with the compliance C of the material,

    error^2 = int (sigma* - sigma) . C (sigma* - sigma) dV / int (sigma . C sigma + (sigma* - sigma) . C (sigma* - sigma)) dV

which is zero for an exact stress and tends to the error relative to the true stress as elements become smaller. Where the true stress
has no bound, at sharp inner corners and at the rims of what is held rigidly, it falls slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
import skfem
from scipy import sparse
from skfem.quadrature import get_quadrature

from preprocessing.elements.solid_elements import ElementBlock, points_of, wedge_points
from preprocessing.mesh.faces import ALL_CORNERS, BoundaryFaces, BoundaryLines
from toolkit.foundation.errors import InputError

AXES = {"xx": (0, 0), "yy": (1, 1), "xy": (0, 1)}
COMPONENTS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Axes of the six components in space, in their order: xx, yy, zz, yz, xz, xy."""
MIDDLE_OF_EDGE = (np.array([[0.5]]), np.ones(1))

Rows = tuple[sparse.csr_array, sparse.csr_array]
"""Stress rows for lambda and for mu, sparse (n_stress, n)."""


def stress_rows(
    quantity: str | None,
    blocks: Sequence[ElementBlock],
    boundary: BoundaryLines | BoundaryFaces,
    motion: np.ndarray | None = None,
) -> Rows:
    """Rows of one quantity of the table [stress], for unit Lame's constants; None is that of the dimension.

    Parameters
    ----------
    motion : (n_nodes, 3) in space, for derivatives along it; else None

    Raises
    ------
    InputError
        The quantity is one of the other dimension.
    """
    n = boundary.nodes.size
    if quantity == "none":
        return sparse.csr_array((0, n)), sparse.csr_array((0, n))
    if isinstance(boundary, BoundaryFaces):
        if quantity not in (None, "surface"):
            raise InputError(f'quantity = "{quantity}" is one of plane bodies. Take "surface" or "none".')
        return surface_rows(blocks, boundary.nodes, boundary.points, motion)
    if quantity == "surface":
        raise InputError('quantity = "surface" is that of spatial bodies. Take "tangential", "xx", "yy", "xy" or "none".')
    quantity = quantity or "tangential"
    if quantity == "tangential":
        return _along(blocks, boundary)
    a, b = AXES[quantity]
    found = []
    for block in blocks:
        functions = block.functions_at(_centre(block)[:, None])
        found.append(_rows(_gradients(functions), block.connectivity, np.eye(2)[[a]], np.eye(2)[[b]], n))
    return tuple(sparse.vstack(parts, format="csr") for parts in zip(*found, strict=True))  # type: ignore[return-value]


def _centre(block: ElementBlock) -> np.ndarray:
    """Centre of the reference element."""
    return block.geometry.elem.refdom.p.mean(axis=1)


def _along(blocks: Sequence[ElementBlock], outline: BoundaryLines) -> Rows:
    """Stress along the boundary in the middle of its edges, in their order."""
    n, places, found = outline.nodes.size, [], []
    number = {tuple(sorted(pair)): k for k, pair in enumerate(outline.edges[:, :2].tolist())}
    for block in blocks:
        corners = _corner_nodes(block)[block.geometry.facets].T.tolist()  # nodes at both ends of every edge
        facets = [k for k, pair in enumerate(corners) if tuple(sorted(pair)) in number]
        if not facets:
            continue
        functions = skfem.FacetBasis(block.geometry, block.shapes, facets=np.array(facets), quadrature=MIDDLE_OF_EDGE)
        normal = functions.normals[:, :, 0].T
        tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
        found.append(_rows(_gradients(functions), block.connectivity[functions.tind], tangent, tangent, n))
        places += [number[tuple(sorted(corners[k]))] for k in functions.find]
    order = np.argsort(places)
    return tuple(sparse.vstack(parts, format="csr")[order] for parts in zip(*found, strict=True))  # type: ignore[return-value]


def _corner_nodes(block: ElementBlock) -> np.ndarray:
    """Node of every vertex of scikit-fem's mesh."""
    vertices = block.geometry.t
    found = np.zeros(vertices.max() + 1, int)
    found[vertices] = block.connectivity[:, : len(vertices)].T
    return found


def surface_rows(blocks: Sequence[ElementBlock], nodes: np.ndarray, points: np.ndarray, motion: np.ndarray | None = None) -> Rows:
    """Six rows for every point, a node of the surface; with a motion of the nodes (n_nodes, 3), their derivatives along it.

    Parameters
    ----------
    nodes : (n_nodes, 3)
    points : (n_points,) numbers of nodes
    """
    where = np.full(len(nodes), -1)
    where[points] = np.arange(len(points))
    meeting = np.bincount(np.concatenate([block.connectivity.ravel() for block in blocks]), minlength=len(nodes))
    found: list[sparse.csr_array] = [sparse.csr_array((6 * len(points), nodes.size)) for _ in range(2)]
    for block in blocks:
        touching = np.flatnonzero((where[block.connectivity] >= 0).any(axis=1))
        every = _gradients_at_nodes(block, touching, nodes, motion)
        for k in range(block.connectivity.shape[1]):
            on = where[block.connectivity[touching, k]] >= 0
            members = block.connectivity[touching[on]]
            here = members[:, k]
            shares = (every[..., k][:, on] / meeting[here][:, None]).transpose(1, 2, 0)
            entries = (_normal_rows(shares, members, where[here]), _shear_rows(shares, members, where[here]))
            found = [
                total + sparse.coo_array((value, (row, column)), shape=total.shape).tocsr()
                for total, (value, row, column) in zip(found, entries, strict=True)
            ]
    return found[0], found[1]


def _gradients_at_nodes(block: ElementBlock, elements: np.ndarray, nodes: np.ndarray, motion: np.ndarray | None) -> np.ndarray:
    """Gradients of the shape functions i at the nodes k of some elements, (3, n_e, i, k), or their rates along a motion."""
    functions = block.functions_at(block.shapes.doflocs.T, elements)
    gradients = np.stack([functions.basis[i][0].grad for i in range(functions.Nbfun)], axis=2)
    if motion is None:
        return gradients
    slope = np.einsum("aeik,eic->caek", gradients, motion[block.connectivity[elements]])
    return -np.einsum("caek,ceik->aeik", slope, gradients)


def _normal_rows(gradients: np.ndarray, members: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Values, rows and columns of tr eps in the first three rows of points, one point for each element, by gradients (n_e, i, 3)."""
    row = 6 * points[:, None, None, None] + np.arange(3)[:, None, None]
    return _flat(gradients[:, None], row, 3 * members[:, None, :, None] + np.arange(3))


def _shear_rows(gradients: np.ndarray, members: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Values, rows and columns of 2 a . eps b in all six rows: the derivative along b of displacement along a, and vice versa."""
    axes = np.array(COMPONENTS)
    values = np.moveaxis(gradients[:, :, axes[:, ::-1]], 2, 1)
    row = 6 * points[:, None, None, None] + np.arange(6)[:, None, None]
    return _flat(values, row, 3 * members[:, None, :, None] + axes[:, None])


def _flat(*each: np.ndarray) -> tuple[np.ndarray, ...]:
    return tuple(every.ravel() for every in np.broadcast_arrays(*each))


def _gradients(functions: skfem.CellBasis) -> np.ndarray:
    """Gradients of all shape functions at one point of each element, (d, n_e, n_local)."""
    return np.stack([functions.basis[i][0].grad[:, :, 0] for i in range(functions.Nbfun)], axis=2)


def _rows(gradient: np.ndarray, members: np.ndarray, a: np.ndarray, b: np.ndarray, n: int) -> Rows:
    """Rows for lambda and mu at one point of each element, its nodes being `members` (n_e, n_local); a, b are (n_e or 1, d)."""
    each = (len(members), len(gradient))
    along_a, along_b = (np.einsum("ed,dei->ei", np.broadcast_to(v, each), gradient) for v in (a, b))
    first = np.einsum("e,dei->eid", np.sum(np.broadcast_to(a * b, each), axis=1), gradient)
    shear = along_b[:, :, None] * a[:, None, :] + along_a[:, :, None] * b[:, None, :]
    return _placed(first, members, n), _placed(shear, members, n)


def _placed(values: np.ndarray, members: np.ndarray, n: int) -> sparse.csr_array:
    """Values (n_e, n_local, d) at the nodal coordinates of the members, one row for each element."""
    d = values.shape[2]
    column = d * members[:, :, None] + np.arange(d)
    row = np.broadcast_to(np.arange(len(members))[:, None, None], column.shape)
    return sparse.coo_array((values.ravel(), (row.ravel(), column.ravel())), shape=(len(members), n)).tocsr()


LINEAR = ("triangle", "quad", "tetra", "hexahedron", "wedge")
"""Kinds whose stress a linear polynomial is fitted to; of the others a quadratic one."""
SAMPLED = {"triangle6": 2, "quad8": 5, "quad9": 5, "tetra10": 2, "hexahedron20": 5, "hexahedron27": 5}
WEDGES = {"wedge": (1, 3), "wedge15": (2, 5)}
"""Order of the points that a kind is sampled at, of wedges across and along: one point of linear elements (of wedges two), three or four
of triangles and tetrahedra with middles of edges, and three in each direction of squares and cubes and along wedges: two could not tell a
quadratic polynomial across one layer."""
STRAIGHT = {
    "triangle": skfem.ElementTriP1, "quad": skfem.ElementQuad1, "tetra": skfem.ElementTetP1, "hexahedron": skfem.ElementHex1,
    "wedge": skfem.ElementWedge1,
}  # fmt: skip
"""Shape functions of the corners."""
PATCH_GROWTHS = 3
"""Number of times that a patch may grow."""
OPEN_TERM_EIGENVALUE = 1e-6
"""Part of the largest eigenvalue of a patch's normal matrix below which its points leave a term open."""


@dataclass(frozen=True, eq=False)
class RecoveredStress:
    """Smooth stress field of polynomials around the corners."""

    nodes: np.ndarray  # (n_nodes, d)
    order: int
    radius: np.ndarray  # (n_nodes,) of every patch, which its monomials are scaled by
    coefficients: np.ndarray  # (n_nodes, n_terms, k)

    def at(self, block: ElementBlock, elements: np.ndarray, functions: skfem.CellBasis, points: np.ndarray) -> np.ndarray:
        """Values (n_e, n_points, k) at points (d, n_points) of the reference element of some elements."""
        corners, straight = _corners(block)[elements], STRAIGHT[_family(block)]()
        x = np.moveaxis(np.asarray(functions.global_coordinates()), 0, -1)
        total = np.zeros((*x.shape[:2], self.coefficients.shape[2]))
        for i, corner in enumerate(_in_order_of(straight, block, corners).T):
            terms = monomials((x - self.nodes[corner][:, None]) / self.radius[corner, None, None], self.order)
            total += straight.lbasis(points, i)[0][:, None] * np.einsum("eqk,ekc->eqc", terms, self.coefficients[corner])
        return total


def recovered(blocks: Sequence[ElementBlock], nodes: np.ndarray, samples: Sequence[np.ndarray]) -> RecoveredStress:
    """Smooth stress field, recovered from samples in the elements.

    Parameters
    ----------
    samples : of every block (n_e, n_points, k), at `sample_points`
    """
    order = 1 if all(block.kind in LINEAR for block in blocks) else 2
    places, corners, members = _places(blocks)
    values = np.concatenate([each.reshape(-1, each.shape[-1]) for each in samples])
    meeting = _incidence(corners, (len(nodes), int(members.max()) + 1))
    sampled = _incidence(np.column_stack([members, np.arange(len(members))]), (meeting.shape[1], len(members)))
    found = _fit(nodes, places, meeting @ sampled, order)
    lacking, grown = found.lacking, meeting
    for _ in range(PATCH_GROWTHS):
        if not lacking.any():
            break
        grown = (meeting + _recovered_rows(lacking) @ (grown @ (grown.T @ grown))).tocsr()
        still = _fit(nodes, places, grown @ sampled, order).lacking
        meeting = (_recovered_rows(~(lacking & ~still)) @ meeting + _recovered_rows(lacking & ~still) @ grown).tocsr()
        lacking = still
    found = _fit(nodes, places, meeting @ sampled, order)
    return RecoveredStress(nodes, order, found.radius, found.coefficients(values))


@dataclass(frozen=True, eq=False)
class _Fit:
    """Least-squares fit of the polynomials of all patches."""

    radius: np.ndarray  # (n_nodes,)
    used: np.ndarray  # numbers of the corners
    normal: np.ndarray  # (n_used, n_terms, n_terms)
    rows: sparse.csr_array  # (n_nodes n_terms, n_samples)

    @property
    def lacking(self) -> np.ndarray:
        """Whether the points of a patch leave a term open, (n_nodes,)."""
        found, sizes = np.zeros(len(self.radius), bool), np.linalg.eigvalsh(self.normal)
        found[self.used] = sizes[:, 0] < OPEN_TERM_EIGENVALUE * sizes[:, -1]
        return found

    def coefficients(self, values: np.ndarray) -> np.ndarray:
        """Coefficients (n_nodes, n_terms, k) from values (n_samples, k) at the points; zero where there is no corner."""
        right = (self.rows @ values).reshape(len(self.radius), self.normal.shape[1], -1)
        found = np.zeros_like(right)
        found[self.used] = np.linalg.pinv(self.normal, rcond=OPEN_TERM_EIGENVALUE, hermitian=True) @ right[self.used]
        return found


def _fit(nodes: np.ndarray, places: np.ndarray, patches: sparse.csr_array, order: int) -> _Fit:
    """Fit of patches (n_nodes, n_samples) of samples at places (n_samples, d)."""
    patches = patches.tocoo()
    centre, sample = patches.row, patches.col
    arms = places[sample] - nodes[centre]
    np.maximum.at(radius := np.zeros(len(nodes)), centre, np.linalg.norm(arms, axis=1))
    radius[radius == 0] = 1.0
    terms = monomials(arms / radius[centre, None], order)
    n, shape = terms.shape[1], (len(nodes), terms.shape[1], terms.shape[1])
    normal = np.zeros(shape)
    for i, j in combinations_with_replacement(range(n), 2):
        normal[:, i, j] = normal[:, j, i] = np.bincount(centre, terms[:, i] * terms[:, j], len(nodes))
    row = centre[:, None] * n + np.arange(n)
    column = np.broadcast_to(sample[:, None], row.shape)
    rows = sparse.csr_array((terms.ravel(), (row.ravel(), column.ravel())), shape=(len(nodes) * n, len(places)))
    used = np.unique(centre)
    return _Fit(radius, used, normal[used], rows)


def _recovered_rows(chosen: np.ndarray) -> sparse.dia_array:
    """Sparse matrix that keeps some rows, and makes others zero."""
    return sparse.diags_array(chosen.astype(float))


def _incidence(pairs: np.ndarray, shape: tuple[int, int]) -> sparse.csr_array:
    """Sparse matrix with ones at pairs (n, 2)."""
    return sparse.csr_array((np.ones(len(pairs)), pairs.T), shape=shape)


def sample_points(block: ElementBlock) -> np.ndarray:
    """Sample points (d, n_points) of the reference element."""
    if block.kind in WEDGES:
        return wedge_points(*WEDGES[block.kind])[0]
    return get_quadrature(block.shapes.refdom, SAMPLED.get(block.kind, 1))[0]


def monomials(x: np.ndarray, order: int) -> np.ndarray:
    """All products of up to `order` coordinates of x (..., d), at [..., term]."""
    terms = [np.ones(x.shape[:-1])]
    for degree in range(1, order + 1):
        terms += [x[..., list(axes)].prod(axis=-1) for axes in combinations_with_replacement(range(x.shape[-1]), degree)]
    return np.stack(terms, axis=-1)


def _places(blocks: Sequence[ElementBlock]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places (n, d) of all samples; pairs (corner, element); and the element of every sample (n,)."""
    places, corners, members, first = [], [], [], 0
    for block in blocks:
        x = np.moveaxis(np.asarray(block.functions_at(sample_points(block)).global_coordinates()), 0, -1)
        number, own = first + np.arange(len(x)), _corners(block)
        places.append(x.reshape(-1, x.shape[-1]))
        members.append(np.repeat(number, x.shape[1]))
        corners.append(np.column_stack([own.ravel(), np.repeat(number, own.shape[1])]))
        first += len(x)
    return np.concatenate(places), np.concatenate(corners), np.concatenate(members)


def _family(block: ElementBlock) -> str:
    return block.kind.rstrip("0123456789")


def _corners(block: ElementBlock) -> np.ndarray:
    """Nodes at the corners of every element, in the order of its shape functions."""
    return block.connectivity[:, : ALL_CORNERS[block.kind]]


def _in_order_of(straight: skfem.Element, block: ElementBlock, corners: np.ndarray) -> np.ndarray:
    """Corners in the order of the straight element's functions."""
    own, theirs = block.shapes.doflocs[: corners.shape[1]], straight.doflocs
    return corners[:, [int(np.argmin(np.abs(own - place).sum(axis=1))) for place in theirs]]


RIGID_MOTION_ENERGY = 1e-10
"""Energy of a load case, in parts of the largest energy per square of displacement, below which it is a rigid motion."""


@dataclass(frozen=True, eq=False)
class Elastic:
    """Elements of a body, and Lame's constants in any unit."""

    blocks: Sequence[ElementBlock]
    nodes: np.ndarray  # (n_nodes, d)
    lame: tuple[float, float]
    across: float = 0.0  # stress across the plane in parts of the sum of both in it: Poisson's ratio in plane strain

    def stress(self, block: ElementBlock, functions: skfem.CellBasis, moved: np.ndarray) -> np.ndarray:
        """Stress at [e, point, a, b, k] from displacements (n_e, n_local, d, k) of some elements."""
        gradients = np.stack([each[0].grad for each in functions.basis], axis=-1)  # [a, e, point, p]
        slope = np.einsum("aeqp,epck->eqcak", gradients, moved, optimize=True)
        strain, first, shear = (slope + slope.swapaxes(2, 3)) / 2, *self.lame
        return first * np.einsum("eqaak->eqk", strain)[:, :, None, None] * np.eye(len(gradients))[..., None] + 2 * shear * strain

    def energy(self, stress: np.ndarray) -> np.ndarray:
        """Product sigma . C sigma at [e, point, k] of stresses at [e, point, a, b, k]."""
        first, shear = self.lame
        mean = np.einsum("eqaak->eqk", stress)
        return ((stress**2).sum(axis=(2, 3)) - first / (2 * shear + stress.shape[2] * first) * mean**2) / (2 * shear)


@dataclass(frozen=True, eq=False)
class StressErrors:
    """Estimated stress errors of k load cases."""

    relative: np.ndarray  # (k,) nan of one that is a rigid motion
    place: np.ndarray  # (k, d) centre of the element with the largest part of it


def stress_errors(body: Elastic, displacements: np.ndarray) -> StressErrors:
    """Estimated stress errors of displacements (n, k)."""
    k, d = displacements.shape[1], body.nodes.shape[1]
    moved = displacements.reshape(-1, d, k)
    samples = []
    for block in body.blocks:
        functions = block.functions_at(sample_points(block))
        found = body.stress(block, functions, moved[block.connectivity])
        samples.append(found.reshape(*found.shape[:2], -1))
    smooth = recovered(body.blocks, body.nodes, samples)
    energy, error, largest, place = np.zeros(k), np.zeros(k), np.full(k, -1.0), np.zeros((k, d))
    for block in body.blocks:
        for elements, functions in block.functions_in_parts():
            raw = body.stress(block, functions, moved[block.connectivity[elements]])
            off = smooth.at(block, elements, functions, points_of(block.kind)[0]).reshape(raw.shape) - raw
            energy += np.einsum("eqk,eq->k", body.energy(raw), functions.dx)
            each = np.einsum("eqk,eq->ek", body.energy(off), functions.dx)
            error += each.sum(axis=0)
            worst = each.argmax(axis=0)
            centre = body.nodes[block.connectivity[elements[worst]]].mean(axis=1)
            place[each.max(axis=0) > largest] = centre[each.max(axis=0) > largest]
            largest = np.maximum(largest, each.max(axis=0))
    stiff = energy / np.maximum((displacements**2).mean(axis=0), np.finfo(float).tiny)
    relative = np.sqrt(error / np.maximum(energy + error, np.finfo(float).tiny))
    return StressErrors(np.where(stiff > RIGID_MOTION_ENERGY * stiff.max(initial=0.0), relative, np.nan), place)
