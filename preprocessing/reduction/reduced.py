"""The parts of a reduced model that follow from finite elements and a basis: every array, and its dependence on every parameter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from preprocessing.basis.basis import Basis
from preprocessing.basis.basis_choice import BasisChoice
from preprocessing.basis.reduction import reduced_basis
from preprocessing.discretisation.discretisation import STEP, Change, DesignSpace, derivative_of
from preprocessing.discretisation.following_places import with_places
from preprocessing.reduction.beam_sections import KeptSections, beam_sections
from preprocessing.reduction.composition import line_composition
from preprocessing.reduction.contracted import Rate, contracted
from preprocessing.reduction.element_sums import element_sums
from preprocessing.reduction.held_points import with_held_points
from preprocessing.reduction.left_out_shapes import left_out_shapes
from preprocessing.reduction.line_spin import line_spin
from preprocessing.reduction.richer_basis import richer_choices
from preprocessing.reduction.stored_entries import with_more
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.reduced_model.dependence import Derivatives, Polynomial
from toolkit.reduced_model.elements import Elements, SpatialElements
from toolkit.reduced_model.model import InterfacePoint, Invariants, StressPoints
from toolkit.reduced_model.parts.left_out_shapes import LeftOutShapes
from toolkit.reduced_model.parts.spin import Spin
from toolkit.reduced_model.spatial_model import SpatialInvariants

RICHER = ("invariants", "derivatives", "affine", "interfaces", "spin")
"""What a model holds of its richer basis; of a skin the shape too."""


@dataclass(frozen=True)
class Reduced:
    """What `reduce` found; the fields of `ReducedModel` bear the same names."""

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
    """With one basis, as `reduce`."""
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
    if element_parts(choice.kind) and not choice.beside_frozen:
        sums = element_sums(space, nominal, held)
        elements = (sums.elements, sums.derivatives, sums.affine)
    sections = KeptSections() if choice.beside_frozen else beam_sections(space, nominal, changes)
    stored = None if spin is None else spin.found.stored(found.invariants, choice.kind == "full")
    composition = line_composition(space, nominal, still, interfaces)
    rest = left_out_shapes(nominal, matrices, mass, basis)
    return Reduced(space, basis, *found, interfaces, nominal.stress_points, *elements, sections, stored, rest, composition)


SECTIONS = ("sections", "section_derivatives", "section_affine")
"""Parts of a reduced model of beams that hold their sections."""


def element_parts(basis: str) -> tuple[str, ...]:
    """Parts of a reduced model that hold its elements one by one: those with all nodal coordinates have them."""
    return ("elements", "element_derivatives", "element_affine") if basis == "full" else ()


def _held(choice: BasisChoice, clamped_node: int | Sequence[int], n_nodes: int) -> list[int]:
    """Nodes that the frame is tied to; the last one may be -1."""
    return [] if choice.chord is not None else [int(node) % n_nodes for node in np.atleast_1d(clamped_node)]


def _shape_rates(basis: Basis, changes: Sequence[Change]) -> Iterator[np.ndarray]:
    """dZ by each parameter; where no shape follows the design, one after the other."""
    if basis.parts:
        yield from np.moveaxis(basis.rates([change.rates for change in changes]), -1, 0)
    else:
        yield from (basis.rates([change.rates])[:, :, 0] for change in changes)


def _item_rates(change: Change, basis: Basis, d_z: np.ndarray) -> dict[str, np.ndarray]:
    stepped = basis.z.astype(complex)
    stepped.imag = STEP * d_z
    return {name: derivative_of(value) for name, value in change.stepped.items(stepped).items()}
