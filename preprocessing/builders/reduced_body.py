"""From the matrices of a body to its reduced model: basis, contractions and all derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import splu

from preprocessing.builders.discrete_body import DiscreteBody
from preprocessing.elements.section import Monomial, monomial
from preprocessing.elements.solid import QUANTITIES
from preprocessing.elements.stress import Elastic, stress_errors
from preprocessing.mesh.faces import BoundaryLines
from preprocessing.mesh.solid_mesh import SolidMesh, rigid_motions, translations
from preprocessing.reduction.assembly import Matrices
from preprocessing.reduction.basis import BasisChoice
from preprocessing.reduction.body_change import BodyChange
from preprocessing.reduction.chosen_basis import clamped_in_tangent_frame
from preprocessing.reduction.discretisation import STEP, derivative_of
from preprocessing.reduction.invariants import Term, polynomial_of
from preprocessing.reduction.pictured_parts import pressure_on, surface_of
from preprocessing.reduction.reduced import Rate, contracted
from preprocessing.reduction.solid_basis import SolidShapes, solid_shapes
from preprocessing.reduction.spin_stiffening import SpinStiffening, Spun, without_round_off_of_rate
from preprocessing.reduction.stored_entries import ROUND_OFF, with_held_points
from preprocessing.reduction.ties import Freedom, NodeTie, chord_turn, freedom
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.reduced_model.dependence import SparsePolynomial
from toolkit.reduced_model.model import MEAN_AXES, Chord, InterfacePoint, Outline, ReducedModel, StressPoints
from toolkit.reduced_model.parts import SPIN_STIFFENING, Interior, Spin

EXAMINED_MODES, MOST_EXAMINED_SHAPES = 2, 12
"""Modes that are looked at, the lowest ones, and shapes of interface points."""
AXES = "xyz"


class MeshError(NamedTuple):
    """Estimated error of the mesh; the fields of `ReducedModel` have the same names."""

    stress_errors: dict[str, float]  # load case -> error
    stress_error_at: dict[str, float]  # axis -> coordinate of the largest


class ReducedSolid(NamedTuple):
    """Solid with its matrices on the independent coordinates, and the shapes of its basis."""

    body: DiscreteBody
    matrices: Matrices  # on all coordinates
    free: Freedom
    mass: csr_array  # (n^, n^)
    stiffness: csr_array  # (n^, n^)
    shapes: SolidShapes


def reduced_solid(body: DiscreteBody, choice: BasisChoice) -> ReducedSolid:
    """Shapes that a basis choice asks for, with all that they are made of; raises as `solid_shapes`."""
    free = freedom(body.mesh, body.clamped, body.ties)
    matrices = body.parts.at(body.values)
    nodal = map(matrices.coordinates.of_nodes, (matrices.mass, matrices.stiffness))
    mass, stiffness = ((free.map.T @ matrix @ free.map).tocsr() for matrix in nodal)
    motions = free.coordinates_of(rigid_motions(body.mesh.nodes), body.ties)
    shapes = solid_shapes(choice, mass, stiffness, motions, free.places(body.mesh.nodes, body.ties), free, body.ties)
    return ReducedSolid(body, matrices, free, mass, stiffness, shapes)


def mesh_error(solid: ReducedSolid) -> MeshError:
    """Stress errors by load case, and the place of the largest; empty without elements."""
    if solid.body.elastic is None:
        return MeshError({}, {})
    names, columns = _cases(solid)
    if not names:
        return MeshError({}, {})
    found = stress_errors(solid.body.elastic, np.asarray(solid.free.map @ columns))
    known = {name: float(value) for name, value in zip(names, found.relative, strict=True) if np.isfinite(value)}
    if not known:
        return MeshError({}, {})
    place = found.place[names.index(max(known, key=lambda name: known[name]))]
    return MeshError(known, dict(zip(AXES, map(float, place), strict=False)))


def _cases(solid: ReducedSolid) -> tuple[list[str], np.ndarray]:
    """Names of load cases, and their shapes on the independent coordinates."""
    shapes = solid.shapes
    if shapes.system is None:
        return _weights(solid)
    n_modes = shapes.modes.count if shapes.modes else 0
    n_static = shapes.columns.shape[1] - n_modes
    static, modes = min(n_static, MOST_EXAMINED_SHAPES), min(n_modes, EXAMINED_MODES)
    names = [f"interface shape {k + 1}" for k in range(static)] + [f"mode {k + 1}" for k in range(modes)]
    return names, shapes.columns[:, [*range(static), *range(n_static, n_static + modes)]]


def _weights(solid: ReducedSolid) -> tuple[list[str], np.ndarray]:
    """Bending under its own weight along the axes, of a body that keeps all coordinates; nothing if it is not held."""
    factors, nodes = splu(solid.stiffness.tocsc()), solid.body.mesh.nodes
    pivots = np.abs(factors.U.diagonal())
    if pivots.min() <= np.finfo(float).eps * len(pivots) * pivots.max():
        return [], np.zeros((solid.mass.shape[0], 0))
    along = solid.free.map.T @ translations(*nodes.shape)
    return [f"weight along {axis}" for axis in AXES[: nodes.shape[1]]], factors.solve(np.asarray(solid.mass @ along))


@dataclass(frozen=True, eq=False)
class SolidSpin:
    """Spin stiffening of a solid at its nominal design, with its dependence on every parameter."""

    body: DiscreteBody
    matrices: Matrices
    floats: bool
    found: SpinStiffening

    def polynomial(self, spin: Spin, names: list[str]) -> dict[str, SparsePolynomial]:
        """Stress by centrifugal forces grows with the density, in the plane its forces with the width too, and no modulus changes it.

        Forces on concentrated masses are the same at every density. Where they are balanced by the inertia of a body that floats, they are
        no polynomial: the body's share in that follows its density.
        """
        if self._of_ratio:
            return {}
        values = {**self.body.values, **self.body.others}
        constant = np.where(spin.stiffening != 0, self._by_constant_mass, 0.0)
        factors: Monomial = tuple((name, 1) for name in ("density", "width") if name in values)
        terms = list[Term]()
        for powers, share in ((factors, (spin.stiffening - constant) / monomial(values, factors)), ((), constant)):
            here = np.flatnonzero(share)
            terms += [(powers, here, share.ravel()[here])] if len(here) else []
        return {SPIN_STIFFENING: polynomial_of(terms, names)}

    @property
    def _of_ratio(self) -> bool:
        """Whether the centrifugal forces depend on the ratio of concentrated masses to the rest."""
        return self.floats and bool(self.body.parts.constant_mass.parts)

    @property
    def _by_constant_mass(self) -> np.ndarray:
        """Spin stiffening by the forces on concentrated masses."""
        constant = self.body.parts.constant_mass
        return self.found.by(constant.at(self.body.values)) if constant.parts else np.zeros_like(self.found.value)

    def rates(self, parameter: str, change: BodyChange, stepped: Freedom, d_z: np.ndarray) -> dict[str, np.ndarray]:
        """Derivative by what changes the elements, and Z by d_z."""
        nominal, element = self.found.nominal, self.body.element
        assert element is not None
        matrices, values = change.matrices, dict[str, complex](self.body.values)
        if change.mass is not None and self._of_ratio:
            matrices = self.body.parts.derivative(values, parameter)
            values[parameter] += 1j * STEP
        turned = Spun(
            replace(element, stressed=change.stressed),
            values,
            self.matrices.stepped(matrices, 1j * STEP),
            stepped.map,
            nominal.z + 1j * STEP * d_z,
            _motions(change.mesh.nodes, stepped, change.ties, self.floats),
        )
        value = float({**self.body.values, **self.body.others}[parameter])
        return {SPIN_STIFFENING: without_round_off_of_rate(self.found.rate(turned), self.found.value, value)}


def solid_spin(body: DiscreteBody, matrices: Matrices, free: Freedom, z: np.ndarray, floats: bool) -> SolidSpin:
    """Spin stiffening of a body of elements (no finished matrices) that is clamped or floats about mean axes."""
    assert body.element is not None
    nodes = body.mesh.nodes
    spun = Spun(body.element, body.values, matrices, free.map, z, _motions(nodes, free, body.ties, floats))
    return SolidSpin(body, matrices, floats, SpinStiffening(spun, free.places(nodes, body.ties)))


def _motions(nodes: np.ndarray, free: Freedom, ties: Mapping[str, NodeTie], floats: bool) -> np.ndarray | None:
    return free.coordinates_of(rigid_motions(nodes), ties) if floats else None


TRIANGLES = {
    "triangle": ((0, 1, 2),),
    "triangle6": ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)),
    "quad": ((0, 1, 2), (0, 2, 3)),
    "quad8": ((0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 7), (5, 6, 7)),
    "quad9": ((0, 4, 8), (4, 1, 8), (1, 5, 8), (5, 2, 8), (2, 6, 8), (6, 3, 8), (3, 7, 8), (7, 0, 8)),
}
"""Places among the nodes of an element, in the order of mesh files."""
LARGEST_STRESS_ARRAY = 3_000_000
"""Numbers of the stress beyond which there is none: bodies that keep all coordinates of a fine mesh would fill their file with it."""


def inside(body: Elastic | None, mesh: SolidMesh, z: np.ndarray, parameters: Sequence[str]) -> Interior | None:
    """Part `interior` of a reduced model; None without elements or where it is too large.

    Parameters
    ----------
    body : with Lame's constants in parts of the modulus
    z : Z = [xi, Psi] (n, 1 + n_f)
    parameters : names of all, among them the modulus
    """
    if body is None or mesh.dimension != 2 or 4 * len(mesh.nodes) * z.shape[1] > LARGEST_STRESS_ARRAY:
        return None
    every = np.concatenate([block[:, TRIANGLES[kind]].reshape(-1, 3) for kind, block in mesh.blocks.items()])
    points, triangles = np.unique(every, return_inverse=True)
    stress = nodal_stress(body, z[:, 1:])[points]
    modulus = np.array(list(parameters).index("youngs_modulus"))
    return Interior(z.reshape(-1, 2, z.shape[1])[points], triangles.reshape(every.shape), stress, modulus)


def nodal_stress(body: Elastic, displacements: np.ndarray) -> np.ndarray:
    """Stress components xx, yy, zz, xy (n_nodes, 4, k) at all nodes, of displacements (n, k).

    They are the mean of the elements that meet there.
    """
    moved = displacements.reshape(len(body.nodes), 2, -1)
    total, meeting = np.zeros((len(body.nodes), 2, 2, moved.shape[2])), np.zeros(len(body.nodes))
    for block in body.blocks:
        functions = block.functions_at(block.shapes.doflocs.T)
        np.add.at(total, block.connectivity, body.stress(block, functions, moved[block.connectivity]))
        np.add.at(meeting, block.connectivity, 1.0)
    mean = total / np.maximum(meeting, 1.0)[:, None, None, None]
    xx, yy, xy = mean[:, 0, 0], mean[:, 1, 1], mean[:, 0, 1]
    return np.stack([xx, yy, body.across * (xx + yy), xy], axis=1)


LARGEST_ENRICHED = 200_000
"""Nodal coordinates of the largest solid that has more shapes beside frozen ones."""
NEW_SHAPE_PART = 1e-6
"""Part of a derivative of a shape beyond all shapes, below which it is round-off."""


def reduced_body(body: DiscreteBody, choice: BasisChoice, clamp: str, units: str) -> ReducedModel:
    """Reduced model that follows from basis and contractions, without hash and inputs; `clamp` says in words what is held.

    All shapes stay what they are when modulus, density, width or damping change, because their span does: so the invariants are exact
    polynomials of these. Poisson's ratio turns the shapes, unless they are frozen, and places of nodes change all; these have derivatives.
    Beside frozen shapes there are those into which they would turn.
    """
    if _enriched(body, choice):
        body = replace(body, changes=list(body.changes))
    solid = reduced_solid(body, choice)
    free, shapes = solid.free, solid.shapes
    z = np.column_stack([body.mesh.nodes.ravel(), free.map @ shapes.columns])
    nominal = {**body.values, **body.others}
    interfaces = {name: _interface(*each.motion(z), body.mesh.size) for name, each in body.ties.items()}
    interfaces = with_held_points(interfaces, z[:, 1:], body.mesh.size)
    spin = solid_spin(body, solid.matrices, free, z, choice.boundary == "free") if choice.spin_stiffening else None
    rates = ((name, _rate(body, name, change, z, _turned(solid, change, choice), spin)) for name, change in body.changes)
    found = contracted(body.parts, solid.matrices, nominal, z, rates, interfaces, computed=choice.kind != "full")
    stored = None if spin is None else spin.found.stored(found.invariants, choice.kind == "full")
    if spin and stored:
        found = found._replace(affine=found.affine | spin.polynomial(stored, list(nominal)))
    points = len(found.invariants.stress_operator)
    model = ReducedModel(
        dimension=body.mesh.dimension,
        units=units,
        reference_condition=_condition(choice, clamp),
        basis=shapes.words,
        nominal=nominal,
        nominal_units={name: unit(units, QUANTITIES.get(name, "none")) for name in nominal},
        input_hash="",
        writers={} if shapes.system is None else shapes.system.writers,
        **found._asdict(),
        interfaces=interfaces,
        stress=StressPoints(np.arange(points), np.zeros(points, int), np.ones(points, int)),
        spin=stored,
        left_out=shapes.left_out,
        **mesh_error(solid)._asdict(),
    )
    model = _with_richer(model, solid, choice, z)
    return _drawn(model, body, z, coloured=points > 0)


def _condition(choice: BasisChoice, clamp: str) -> str:
    if choice.chord is not None:
        return Chord(*choice.chord).condition
    return MEAN_AXES if choice.boundary == "free" else clamped_in_tangent_frame(f"the nodes of {clamp}")


def _rate(
    body: DiscreteBody, name: str, change: BodyChange, z: np.ndarray, turned: np.ndarray | None, spin: SolidSpin | None = None
) -> Rate:
    """Changes by a parameter with dZ = [dxi, dPsi] (n, 1 + n_f), where dPsi is zero if nothing has `turned`."""
    d_z = np.zeros(z.shape)
    d_z[:, 0] = change.motion
    if turned is not None:
        d_z[:, 1:] = turned
    more = spin.rates(name, change, change.freedom(body.clamped), d_z) if spin else {}
    return Rate(change.matrices, d_z, _item_rates(change, z, d_z) | more)


def _turned(solid: ReducedSolid, change: BodyChange, choice: BasisChoice) -> np.ndarray | None:
    """Derivative dPsi (n, n_f), where Psi = T Psi^; None of frozen shapes, which are the same at every design."""
    if choice.derivative == "frozen":
        return None
    stepped, shapes = change.freedom(solid.body.clamped), solid.shapes
    on_independent = change.on(solid.free, stepped, solid.matrices, shapes.averaged)
    if choice.chord is not None and change.moves:
        turned = chord_turn(Chord(*choice.chord), shapes.points, change.ties)
        on_independent = replace(on_independent, turn=derivative_of(turned))
    return np.asarray(solid.free.map @ shapes.rates(on_independent) + derivative_of(stepped.map) @ shapes.columns)


def _with_richer(model: ReducedModel, solid: ReducedSolid, choice: BasisChoice, z: np.ndarray) -> ReducedModel:
    """Reduced model with a richer basis: frozen shapes, and those that they would turn into.

    Derivatives are then right at the nominal design. It has none where nothing turns the shapes, or modes cannot be followed.
    """
    body = solid.body
    if not _enriched(body, choice) or not body.changes:
        return model
    following = replace(choice, derivative="differentiated")
    try:
        turned = [_turned(solid, change, following) for _, change in body.changes]
    except InputError:  # a cluster of modes is cut
        return model
    richer = np.column_stack([z, _beyond(z[:, 1:], np.column_stack([each for each in turned if each is not None]))])
    interfaces = {name: _interface(*each.motion(richer), body.mesh.size) for name, each in body.ties.items()}
    interfaces = with_held_points(interfaces, richer[:, 1:], body.mesh.size)
    rates = ((name, _rate(body, name, change, richer, None)) for name, change in body.changes)
    found = contracted(body.parts, solid.matrices, model.nominal, richer, rates, interfaces, computed=True)
    loads = None
    if body.boundary is not None and not isinstance(body.boundary, BoundaryLines):
        loads = {name: pressure_on(each.normals(), richer) for name, each in body.pressure_surfaces.items()}
    parts = {f"richer_{name}": part for name, part in found._asdict().items()}
    return replace(model, **parts, richer_interfaces=interfaces, richer_surface_loads=loads)


def _enriched(body: DiscreteBody, choice: BasisChoice) -> bool:
    """Whether the model may hold frozen shapes with more: what each parameter changes is kept at once then."""
    frozen = choice.derivative == "frozen" and choice.kind != "full"
    return frozen and not choice.spin_stiffening and body.mesh.n <= LARGEST_ENRICHED


def _beyond(shapes: np.ndarray, more: np.ndarray) -> np.ndarray:
    """Orthonormal columns (n, k) of what `more` (n, m) has beyond the span of shapes (n, n_f)."""
    known, _ = np.linalg.qr(shapes / np.linalg.norm(shapes, axis=0))
    size = np.linalg.norm(more, axis=0)
    more = more[:, size > 0] / size[size > 0]
    for _ in range(2):
        more = more - known @ (known.T @ more)
    new, parts, _ = np.linalg.svd(more, full_matrices=False)
    return new[:, parts > NEW_SHAPE_PART]


def _drawn(model: ReducedModel, body: DiscreteBody, z: np.ndarray, coloured: bool) -> ReducedModel:
    """Reduced model with its parts for pictures: outline and interior in the plane; surface and its pressures in space."""
    if body.boundary is None or isinstance(body.boundary, BoundaryLines):
        interior = inside(body.elastic, body.mesh, z, model.parameters) if coloured else None
        return replace(model, outline=None if body.boundary is None else _outline(body.boundary, z), interior=interior)
    loads = {name: pressure_on(each.normals(), z) for name, each in body.pressure_surfaces.items()}
    return replace(model, surface=surface_of(body.boundary, z), surface_loads=loads)


def _outline(lines: BoundaryLines, z: np.ndarray) -> Outline:
    """Outline of a plane body: nodes on the boundary, and its edges between them."""
    edges = np.where(lines.edges[:, [2]] >= 0, lines.edges[:, [0, 2, 1]], lines.edges[:, [0, 0, 1]])
    nodes, number = np.unique(edges, return_inverse=True)
    return Outline(z.reshape(-1, 2, z.shape[1])[nodes], number.reshape(edges.shape))


def _interface(position: np.ndarray, rotation: np.ndarray, size: float) -> InterfacePoint:
    """Interface point of a solid, which lies on no curve: its arc length is 0 and cannot change.

    The middle of a ring of nodes is zero but for round-off, as is the rotation of the undeformed body.
    """
    for array, scale in ((position, size), (rotation, 1.0)):
        array[..., 0] = np.where(np.abs(array[..., 0]) > ROUND_OFF * scale, array[..., 0], 0.0)
    return InterfacePoint(np.zeros(()), np.zeros(2), position[None], rotation[None])


def _item_rates(change: BodyChange, z: np.ndarray, d_z: np.ndarray) -> dict[str, np.ndarray]:
    """Derivatives of interface points and pressures."""
    stepped = z + 1j * STEP * d_z
    found: dict[str, np.ndarray] = {}
    for name, each in change.ties.items():
        position, rotation = each.motion(stepped)
        found |= {f"interfaces.{name}.position": position[None], f"interfaces.{name}.rotation": rotation[None]}
    for name, normals in change.normals.items():
        load = pressure_on(normals, stepped)
        found |= {f"surface_loads.{name}.force": load.force, f"surface_loads.{name}.moment": load.moment}
    return {name: derivative_of(item) for name, item in found.items()}
