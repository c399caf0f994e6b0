"""The parts of a reduced model that follow from finite elements and a basis: every array, and its dependence on every parameter."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse import csr_array

from preprocessing.assembly.assembly import Matrices
from preprocessing.basis.basis import Basis
from preprocessing.basis.basis_choice import BasisChoice
from preprocessing.basis.boundary import coordinates_of
from preprocessing.basis.reduction import motions_of_the_frame, per_node, reduced_basis
from preprocessing.discretisation.discretisation import STEP, Change, DesignSpace, Discretisation, derivative_of
from preprocessing.discretisation.following_places import with_places
from preprocessing.reduction.beam_sections import KeptSections, beam_sections
from preprocessing.reduction.composition import line_composition
from preprocessing.reduction.contracted import Rate, contracted
from preprocessing.reduction.element_sums import element_sums
from preprocessing.reduction.held_points import with_held_points
from preprocessing.reduction.spin_stiffening import SpinStiffening, Spun, without_round_off_of_rate
from preprocessing.reduction.stored_entries import joined_rates, with_more
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.reduced_model.dependence import Derivatives, Polynomial
from toolkit.reduced_model.elements import Elements, SpatialElements
from toolkit.reduced_model.model import InterfacePoint, Invariants, StressPoints
from toolkit.reduced_model.parts.left_out_shapes import LeftOutShapes
from toolkit.reduced_model.parts.spin import SPIN_STIFFENING, Spin
from toolkit.reduced_model.spatial_model import SpatialInvariants

LARGEST_FULL = 900
"""Nodal coordinates up to which all are kept: with so many the check takes some 4 s, most of it to compile."""
MORE, MORE_ALONE = 60, 120
"""Modes more than twice those of the frozen basis, beside constraint modes and alone. Errors of too few modes fall with their number at
least, so that twice as many show half of an error in the worst case."""


def richer_choices(choice: BasisChoice, modes: int, n: int) -> list[BasisChoice]:
    """Richer bases to be tried one after the other, for a basis with so many modes and n nodal coordinates.

    None where nothing is frozen, or reduced.
    """
    if choice.derivative != "frozen" or choice.kind == "full":
        return []
    plain: dict[str, Any] = {"frequency": None, "static_error": None, "beside_frozen": True}
    alone = replace(choice, **plain, kind="eigenmodes", count=2 * modes + MORE_ALONE)
    if choice.boundary == "free":
        return [alone]
    if n <= LARGEST_FULL:
        return [replace(choice, **plain, kind="full", count=None)]
    return [replace(choice, **plain, kind="craig-bampton", count=2 * modes + MORE), alone]


@dataclass(frozen=True, eq=False)
class LineSpin:
    """Spin stiffening of a skin or frame at its nominal design."""

    space: DesignSpace
    nominal: Discretisation
    z: Any
    free: Any  # sparse (n, n^): which nodal coordinates the frame leaves free
    floats: bool
    found: SpinStiffening

    def rates(self, parameter: str, d_z: Any = None) -> dict[str, np.ndarray]:
        """Derivative of the spin stiffening by one parameter, which changes Z by d_z."""
        space, z = self.space, self.z
        if d_z is not None:
            z = z + 1j * STEP * (sparse.csr_array(d_z) if sparse.issparse(z) else d_z)
        if parameter in space.in_monomials:
            values: Mapping[str, Any] = {**space.values, parameter: space.values[parameter] + 1j * STEP}
            body = self.nominal
        else:
            values, body = space.values, space.stepped(parameter)
        rate = self.found.rate(_spun(body, values, body.parts.at(values), z, self.free, self.floats))
        return {SPIN_STIFFENING: without_round_off_of_rate(rate, self.found.value, float(space.values[parameter]))}

    def by_monomials(self, parameters: Collection[str]) -> dict[str, Derivatives]:
        """Derivatives of the spin stiffening by parameters that leave Z as it is."""
        names = list(self.space.values)
        return joined_rates({name: self.rates(name) for name in names if name in parameters}, names)


def line_spin(space: DesignSpace, nominal: Discretisation, z: Any, held: Sequence[int], matrices: Matrices) -> LineSpin:
    """Spin stiffening of elements whose frame is tied to the nodes `held`, or floats about mean axes without them."""
    n_nodes, each = len(nominal.nodes), per_node(nominal.nodes)
    kept = np.delete(np.arange(each * n_nodes), coordinates_of(held, n_nodes, each))
    free = sparse.eye_array(each * n_nodes, format="csr")[:, kept]
    found = SpinStiffening(_spun(nominal, space.values, matrices, z, free, not held))
    return LineSpin(space, nominal, z, free, not held, found)


def _spun(body: Discretisation, values: Mapping[str, Any], matrices: Matrices, z: Any, free: Any, floats: bool) -> Spun:
    return Spun(body.element, values, matrices, free, z, motions_of_the_frame(body.nodes) if floats else None)


def left_out_shapes(nominal: Discretisation, matrices: Matrices, mass: Any, basis: Basis) -> LeftOutShapes | None:
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


RICHER = ("invariants", "derivatives", "affine", "interfaces", "spin")
"""Parts of a model that hold its richer basis; of a skin the shape too."""


@dataclass(frozen=True)
class Reduced:
    """Result of `reduce`; the fields of `ReducedModel` have the same names."""

    space: DesignSpace  # with all parameters of the model
    basis: Basis
    invariants: Invariants | SpatialInvariants
    derivatives: dict[str, Derivatives]
    affine: dict[str, Polynomial]
    interfaces: dict[str, InterfacePoint]
    stress: StressPoints
    elements: Elements | SpatialElements | None = None
    element_derivatives: dict[str, Derivatives] | None = None
    element_affine: dict[str, Polynomial] | None = None
    sections: KeptSections = field(default_factory=KeptSections)
    spin: Spin | None = None
    left_out_shapes: LeftOutShapes | None = None
    composition: dict[str, str | int | float] = field(default_factory=dict)
    richer: Reduced | None = None  # of a frozen basis: the same body in more shapes

    def fields(self, units: str) -> dict[str, Any]:
        """Arguments of `ReducedModel`."""
        return {
            "dimension": 3 if isinstance(self.invariants, SpatialInvariants) else 2,
            "units": units,
            "reference_condition": self.basis.reference_condition,
            "basis": self.basis.description,
            "left_out": dict(self.basis.left_out),
            "nominal": {name: float(np.real(value)) for name, value in self.space.values.items()},
            "nominal_units": {name: unit(units, quantity) for name, quantity in self.space.quantities.items()},
            **{name: getattr(self, name) for name in ("invariants", "derivatives", "affine", "interfaces", "stress")},
            **{
                name: getattr(self, name)
                for name in ("elements", "element_derivatives", "element_affine", "spin", "left_out_shapes", "composition")
            },
            **self.sections._asdict(),
            **({} if self.richer is None else {f"richer_{name}": getattr(self.richer, name) for name in RICHER}),
        }


def reduce(space: DesignSpace, choice: BasisChoice, clamped_node: int | Sequence[int], clamp: str) -> Reduced:
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


def _reduced(space: DesignSpace, choice: BasisChoice, clamped_node: int | Sequence[int], clamp: str) -> Reduced:
    """Reduction with one basis, as `reduce`."""
    space = with_places(space, choice.followed)
    nominal = space.nominal()
    matrices = nominal.parts.at(space.values)
    mass, stiffness = nominal.nodal(matrices.mass), nominal.nodal(matrices.stiffness)
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
    elements: tuple[Any, Any, Any] = (None, None, None)
    if not choice.beside_frozen:
        sums = element_sums(space, nominal, still)
        elements = (sums.elements, sums.derivatives, sums.affine)
    sections = KeptSections() if choice.beside_frozen else beam_sections(space, nominal, changes)
    stored = None if spin is None else spin.found.stored(found.invariants, choice.kind == "full")
    composition = line_composition(space, nominal, still, interfaces)
    rest = left_out_shapes(nominal, matrices, mass, basis)
    return Reduced(space, basis, *found, interfaces, nominal.stress_points, *elements, sections, stored, rest, composition)


ELEMENT_PARTS = ("elements", "element_derivatives", "element_affine")
"""Parts of a reduced model that hold its elements one by one, which several frames are made of, whatever shapes one frame keeps."""
SECTIONS = ("sections", "section_derivatives", "section_affine")
"""Parts of a reduced model of beams that hold their sections."""


def _held(choice: BasisChoice, clamped_node: int | Sequence[int], n_nodes: int) -> list[int]:
    """Nodes that the frame is tied to; the last one may be -1."""
    return [] if choice.chord is not None else [int(node) % n_nodes for node in np.atleast_1d(clamped_node)]


def _shape_rates(basis: Basis, changes: Sequence[Change]) -> Iterator[np.ndarray]:
    """Derivatives dZ by each parameter; where no shape follows the design, one after the other."""
    if basis.parts:
        yield from np.moveaxis(basis.rates([change.rates for change in changes]), -1, 0)
    else:
        yield from (basis.rates([change.rates])[:, :, 0] for change in changes)


def _item_rates(change: Change, basis: Basis, d_z: np.ndarray) -> dict[str, np.ndarray]:
    stepped = basis.z.astype(complex)
    stepped.imag = STEP * d_z
    return {name: derivative_of(value) for name, value in change.stepped.items(stepped).items()}
