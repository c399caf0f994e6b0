"""The parts of a reduced model that follow from finite elements and a basis: every array, and its dependence on every parameter."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csr_array, issparse

from preprocessing.mesh.solid_mesh import SolidMesh
from preprocessing.reduction.assembly import Matrices, Parts
from preprocessing.reduction.basis import BasisChoice, ReductionBasis
from preprocessing.reduction.boundary import coordinates_of
from preprocessing.reduction.chosen_basis import motions_of_the_frame, per_node, reduced_basis
from preprocessing.reduction.discretisation import STEP, DesignChange, DesignSpace, Discretisation, derivative_of, with_places
from preprocessing.reduction.element_sums import ElementSums, KeptSections, beam_sections, element_sums
from preprocessing.reduction.invariants import contract, contract_derivative, polynomials, whole_arrays, with_roots
from preprocessing.reduction.spin_stiffening import SpinStiffening, Spun, without_round_off_of_rate
from preprocessing.reduction.stored_entries import (
    AnyInvariants,
    derivatives,
    joined_rates,
    polynomials_without_round_off,
    with_held_points,
    with_more,
    without_round_off,
)
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.foundation.value_types import Matrix
from toolkit.reduced_model.composition import (
    LONGEST_SENTENCE,
    Attributes,
    Composition,
    KeptLeftOut,
    KeptMass,
    PlaceOfNodes,
    place_of,
    plain_text,
)
from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial
from toolkit.reduced_model.model import InterfacePoint, Invariants, ReducedModel, StressPoints
from toolkit.reduced_model.parts import SPIN_STIFFENING, Elements, LeftOutShapes, SpatialElements, SpatialInvariants, Spin


def mesh_composition(mesh: SolidMesh, volume: float | None, clamped: np.ndarray, tied: Mapping[str, np.ndarray]) -> Attributes:
    """Composition of a body of solid elements, or of finished matrices.

    Parameters
    ----------
    volume : of its elements; None where it is not known
    clamped, tied : numbers of the clamped nodes, and of those that carry each interface point
    """
    return Composition(
        nodes=len(mesh.nodes),
        elements={kind: len(block) for kind, block in mesh.blocks.items()},
        volume=volume,
        interface_points={name: len(nodes) for name, nodes in tied.items()},
        clamp=_place(mesh.nodes, clamped) if len(clamped) else None,
        groups={plain_text(name): _place(mesh.nodes, nodes) for name, nodes in mesh.groups.items()},
        masses=[KeptMass(each.mass, [*each.place], len(each.carriers), plain_text(each.source)) for each in mesh.masses],
        left_out=[KeptLeftOut(plain_text(what), n, plain_text(why, LONGEST_SENTENCE)) for what, n, why in mesh.left_out],
        remarks=[plain_text(text, LONGEST_SENTENCE) for text in mesh.remarks],
    ).attributes()


def line_composition(
    space: DesignSpace, nominal: Discretisation, held: Sequence[int], interfaces: Mapping[str, InterfacePoint]
) -> Attributes:
    """Composition of a skin or a frame; `held` are the numbers of the clamped nodes."""
    nodes = np.real(nominal.nodes)
    return Composition(
        nodes=len(nodes),
        elements={"beam": len(nominal.element.connectivity)},
        volume=_volume_of_lines(space, nominal.parts),
        interface_points={name: 2 if np.ptp(point.arc_length_range) > 0 else 1 for name, point in interfaces.items()},
        clamp=_place(nodes, np.asarray(held)) if len(held) else None,
    ).attributes()


def _place(nodes: np.ndarray, numbers: np.ndarray) -> PlaceOfNodes:
    return place_of(nodes[numbers].tolist())


def _volume_of_lines(space: DesignSpace, parts: Parts) -> float | None:
    """The mass that the body would have if every density were one; None where some of its mass has no density."""
    dense = {name for name, quantity in space.quantities.items() if quantity == "density"}
    along = [part for part in parts.parts if part.name == (0, 0)]
    if not all(dense & dict(part.factors).keys() for part in along):
        return None
    at_one = {**space.values, **dict.fromkeys(dense, 1.0)}
    motion = parts.coordinates.translations[0]
    mass = replace(parts, parts=tuple(along)).at(at_one).m[0]
    return float(np.real(motion @ (mass @ motion)))


class Rate(NamedTuple):
    """Changes by one parameter: of matrices, shapes and other arrays."""

    matrices: Matrices
    z: np.ndarray  # dZ = [dxi, dPsi] (n, 1 + n_f)
    items: Mapping[str, np.ndarray]  # derivatives of arrays besides the invariants


class Contracted(NamedTuple):
    """Invariants with derivatives and polynomials; the fields of `ReducedModel` have the same names."""

    invariants: AnyInvariants
    derivatives: dict[str, Derivatives]
    affine: dict[str, SparsePolynomial]


def contracted(
    parts: Parts,
    matrices: Matrices,
    values: Mapping[str, float],
    z: np.ndarray,
    rates: Iterable[tuple[str, Rate]],
    interfaces: Mapping[str, InterfacePoint],
    computed: bool,
    exact: bool = True,
) -> Contracted:
    """Contract the matrices at all parameters `values` with Z = [xi, Psi], and differentiate.

    Parameters
    ----------
    rates : parameter -> what it changes, of those by which there are derivatives
    computed : whether the shapes were computed, or are those of a full basis
    exact : whether there are polynomials
    """
    names = list(values)
    shapes = z if computed else csr_array(z)  # shapes that select coordinates are zero nearly everywhere
    by_parameter = {name: {**_rates(matrices, rate, shapes), **rate.items} for name, rate in rates}
    affine = polynomials(parts, names, z, computed) if exact else {}
    invariants = with_roots(contract(matrices, shapes), parts, values, shapes)
    found = derivatives(invariants, by_parameter, names, computed, interfaces)
    if not computed:
        invariants = whole_arrays(without_round_off(invariants), matrices.components)
        affine = polynomials_without_round_off(affine, invariants, [float(np.real(value)) for value in values.values()])
    return Contracted(invariants, found, affine)


def _rates(matrices: Matrices, rate: Rate, shapes: Matrix) -> dict[str, Matrix]:
    """Derivatives of the invariants, sparse as the shapes are."""
    d_shapes = csr_array(rate.z) if issparse(shapes) else rate.z
    return vars(contract_derivative(matrices, rate.matrices, shapes, d_shapes))


LARGEST_FULL = 900
"""Nodal coordinates up to which all are kept: with so many the check takes some 4 s, most of it to compile."""
ENRICHING_MODES, ENRICHING_MODES_ALONE = 60, 120
"""Modes more than twice those of the frozen basis, beside constraint modes and alone. Errors of too few modes fall with their number at
least, so that twice as many show half of an error in the worst case."""


def richer_choices(choice: BasisChoice, modes: int, n: int) -> list[BasisChoice]:
    """Richer bases to be tried one after the other, for a basis with so many modes and n nodal coordinates.

    None where nothing is frozen, or reduced.
    """
    if choice.derivative != "frozen" or choice.kind == "full":
        return []
    more = 2 * modes + ENRICHING_MODES_ALONE
    alone = replace(choice, kind="eigenmodes", count=more, frequency=None, static_error=None, beside_frozen=True)
    if choice.boundary == "free":
        return [alone]
    if n <= LARGEST_FULL:
        return [replace(alone, kind="full", count=None)]
    return [replace(alone, kind="craig-bampton", count=2 * modes + ENRICHING_MODES), alone]


@dataclass(frozen=True, eq=False)
class LineSpin:
    """Spin stiffening of a skin or frame at its nominal design."""

    space: DesignSpace
    nominal: Discretisation
    z: Matrix
    free: csr_array  # (n, n^): which nodal coordinates the frame leaves free
    floats: bool
    found: SpinStiffening

    def rates(self, parameter: str, d_z: Matrix | None = None) -> dict[str, np.ndarray]:
        """Derivative of the spin stiffening by one parameter, which changes Z by d_z."""
        space, z = self.space, self.z
        if d_z is not None:
            z = z + 1j * STEP * (sparse.csr_array(d_z) if sparse.issparse(z) else d_z)
        if parameter in space.in_monomials:
            values: Mapping[str, complex] = {**space.values, parameter: space.values[parameter] + 1j * STEP}
            body = self.nominal
        else:
            values, body = space.values, space.stepped(parameter)
        rate = self.found.rate(_spun(body, values, body.parts.at(values), z, self.free, self.floats))
        return {SPIN_STIFFENING: without_round_off_of_rate(rate, self.found.value, float(space.values[parameter]))}

    def by_monomials(self, parameters: Collection[str]) -> dict[str, Derivatives]:
        """Derivatives of the spin stiffening by parameters that leave Z as it is."""
        names = list(self.space.values)
        return joined_rates({name: self.rates(name) for name in names if name in parameters}, names)


def line_spin(space: DesignSpace, nominal: Discretisation, z: Matrix, held: Sequence[int], matrices: Matrices) -> LineSpin:
    """Spin stiffening of elements whose frame is tied to the nodes `held`, or floats about mean axes without them."""
    n_nodes, each = len(nominal.nodes), per_node(nominal.nodes)
    kept = np.delete(np.arange(each * n_nodes), coordinates_of(held, n_nodes, each))
    free = sparse.eye_array(each * n_nodes, format="csr")[:, kept]
    found = SpinStiffening(_spun(nominal, space.values, matrices, z, free, not held))
    return LineSpin(space, nominal, z, free, not held, found)


def _spun(
    body: Discretisation, values: Mapping[str, complex], matrices: Matrices, z: Matrix, free: csr_array, floats: bool
) -> Spun:
    return Spun(body.element, values, matrices, free, z, motions_of_the_frame(body.nodes) if floats else None)


def left_out_shapes(nominal: Discretisation, matrices: Matrices, mass: csr_array, basis: ReductionBasis) -> LeftOutShapes | None:
    """Static responses of left-out shapes at the nominal design, with the nodal mass (n, n); None if none is left out."""
    if basis.beyond is None or not basis.beyond.count:
        return None
    rows = nominal.interface_rows()
    loads = np.column_stack(
        [*(rows[name].T for name in sorted(rows)), mass @ np.column_stack([pulls(nominal.nodes), basis.z[:, 1:]])]
    )
    shapes = basis.beyond.columns / np.sqrt(basis.beyond.eigenvalues)
    seen = shapes.T @ loads
    return LeftOutShapes(seen.T @ seen, matrices.stress @ matrices.coordinates.displacement(shapes @ seen))


def pulls(nodes: np.ndarray) -> np.ndarray:
    """Accelerations (n, d + d d) of nodes (n_nodes, d): along each axis a, and along a as the place along b, turning with their field."""
    count, d = nodes.shape
    found = np.zeros((count, per_node(nodes), d + d * d))
    for a in range(d):
        found[:, a, a] = 1.0
        for b in range(d):
            found[:, a, d + d * a + b] = nodes[:, b]
            if a != b and d == 2:
                found[:, 2, d + d * a + b] = (a - b) / 2
            elif a != b:
                found[:, 3 + 3 - a - b, d + d * a + b] = (1 if (a - b) % 3 == 1 else -1) / 2
    return found.reshape(-1, d + d * d)


STORED = (
    "invariants", "derivatives", "affine", "interfaces", "stress", "elements", "element_derivatives", "element_affine", "spin",
    "left_out_shapes", "composition",
)  # fmt: skip
"""Parts of a model that stand in `ReducedParts` under the same names."""
RICHER = ("invariants", "derivatives", "affine", "interfaces", "spin")
"""Parts of a model that hold its richer basis; of a skin the shape too."""


@dataclass(frozen=True)
class ReducedParts:
    """Result of `reduce`."""

    space: DesignSpace  # with all parameters of the model
    basis: ReductionBasis
    invariants: Invariants | SpatialInvariants
    derivatives: dict[str, Derivatives]
    affine: dict[str, SparsePolynomial]
    interfaces: dict[str, InterfacePoint]
    stress: StressPoints
    elements: Elements | SpatialElements | None = None
    element_derivatives: dict[str, Derivatives] | None = None
    element_affine: dict[str, SparsePolynomial] | None = None
    sections: KeptSections = field(default_factory=KeptSections)
    spin: Spin | None = None
    left_out_shapes: LeftOutShapes | None = None
    composition: dict[str, str | int | float] = field(default_factory=dict)
    richer: ReducedParts | None = None  # of a frozen basis: the same body in more shapes

    def model(self, units: str) -> ReducedModel:
        """Reduced model of these parts, to which its recipe adds pictures, writers and the hash of its inputs."""
        return ReducedModel(
            dimension=3 if isinstance(self.invariants, SpatialInvariants) else 2,
            units=units,
            reference_condition=self.basis.reference_condition,
            basis=self.basis.description,
            nominal={name: float(np.real(value)) for name, value in self.space.values.items()},
            nominal_units={name: unit(units, quantity) for name, quantity in self.space.quantities.items()},
            input_hash="",
            writers={},
            left_out=dict(self.basis.left_out),
            **{name: getattr(self, name) for name in STORED},
            **self.sections._asdict(),
            **({} if self.richer is None else {f"richer_{name}": getattr(self.richer, name) for name in RICHER}),
        )


def reduce(space: DesignSpace, choice: BasisChoice, clamped_node: int | Sequence[int], clamp: str) -> ReducedParts:
    """Contract the finite elements of a body with a basis, and differentiate everything by all parameters.

    A frozen basis comes with a richer one, see `richer_basis`.

    Where the basis does not depend on a parameter by which the matrices are polynomials, the invariants are polynomials too; all
    other dependence is held as derivatives at the nominal design.

    Parameters
    ----------
    clamped_node : number of the node, or of the nodes, that a tangent frame is tied to, and `clamp`, what it is called

    Raises
    ------
    InputError
        The basis cannot be had, see `reduced_basis`.
    """
    found = _reduced(space, choice, clamped_node, clamp)
    for each in richer_choices(choice, len(found.basis.frequencies), len(found.basis.z)):
        with suppress(InputError):  # its interface points make no constraint modes
            return replace(found, richer=_reduced(space, each, clamped_node, clamp))
    return found


def _reduced(space: DesignSpace, choice: BasisChoice, clamped_node: int | Sequence[int], clamp: str) -> ReducedParts:
    """Reduction with one basis, as `reduce`."""
    space = with_places(space, choice.followed)
    nominal = space.nominal()
    matrices = nominal.parts.at(space.values)
    mass, stiffness = map(matrices.coordinates.of_nodes, (matrices.mass, matrices.stiffness))
    basis = reduced_basis(choice, mass, stiffness, nominal.nodes, clamped_node, clamp, nominal.interface_rows())
    exact = space.in_monomials if basis.constant else frozenset()
    changes = {parameter: space.change(nominal, parameter) for parameter in space.values if parameter not in exact}
    held = _held(choice, clamped_node, len(nominal.nodes))
    still = [] if choice.boundary == "free" else held
    shapes = csr_array(basis.z) if choice.kind == "full" else basis.z
    spin = line_spin(space, nominal, shapes, still, matrices) if choice.spin_stiffening else None
    rates = (
        (parameter, Rate(change.matrices, d, _item_rates(change, basis, d) | (spin.rates(parameter, d) if spin else {})))
        for (parameter, change), d in zip(changes.items(), _shape_rates(basis, list(changes.values())), strict=True)
    )
    size = float(np.ptp(np.real(nominal.nodes), axis=0).max())
    interfaces = with_held_points(nominal.interfaces(basis.z), nominal.positions(basis.z)[..., 1:], size)
    found = contracted(
        nominal.parts, matrices, space.values, basis.z, rates, interfaces, computed=choice.kind != "full", exact=bool(exact)
    )
    by_monomials = spin.by_monomials(exact) if spin else {}
    found = found._replace(derivatives=with_more(found.derivatives, by_monomials))
    elements = ElementSums() if choice.beside_frozen else element_sums(space, nominal, still)
    sections = KeptSections() if choice.beside_frozen else beam_sections(space, nominal, changes)
    stored = None if spin is None else spin.found.stored(found.invariants, choice.kind == "full")
    composition = line_composition(space, nominal, still, interfaces)
    rest = left_out_shapes(nominal, matrices, mass, basis)
    return ReducedParts(space, basis, *found, interfaces, nominal.stress_points, *elements, sections, stored, rest, composition)


ELEMENT_PARTS = ("elements", "element_derivatives", "element_affine")
"""Parts of a reduced model that hold its elements one by one, which several frames are made of, whatever shapes one frame keeps."""
SECTIONS = ("sections", "section_derivatives", "section_affine")
"""Parts of a reduced model of beams that hold their sections."""


def _held(choice: BasisChoice, clamped_node: int | Sequence[int], n_nodes: int) -> list[int]:
    """Nodes that the frame is tied to; the last one may be -1."""
    return [] if choice.chord is not None else [int(node) % n_nodes for node in np.atleast_1d(clamped_node)]


def _shape_rates(basis: ReductionBasis, changes: Sequence[DesignChange]) -> Iterator[np.ndarray]:
    """Derivatives dZ by each parameter; where no shape follows the design, one after the other."""
    if basis.parts:
        yield from np.moveaxis(basis.rates([change.rates for change in changes]), -1, 0)
    else:
        yield from (basis.rates([change.rates])[:, :, 0] for change in changes)


def _item_rates(change: DesignChange, basis: ReductionBasis, d_z: np.ndarray) -> dict[str, np.ndarray]:
    stepped = basis.z.astype(complex)
    stepped.imag = STEP * d_z
    return {name: derivative_of(value) for name, value in change.stepped.items(stepped).items()}
