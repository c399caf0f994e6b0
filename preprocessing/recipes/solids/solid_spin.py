"""How a spin stiffens a solid, with its dependence on every parameter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from preprocessing.assembly.assembly import Matrices
from preprocessing.assembly.invariants import Term, polynomial_of
from preprocessing.basis.solids.ties import Freedom
from preprocessing.discretisation.body_change import BodyChange
from preprocessing.discretisation.discretisation import STEP
from preprocessing.elements.section import Monomial, monomial
from preprocessing.mesh.solid_mesh import rigid_motions
from preprocessing.recipes.solids.discrete_body import DiscreteBody
from preprocessing.reduction.spin_stiffening import SpinStiffening, Spun, without_round_off_of_rate
from toolkit.reduced_model.dependence import Polynomial
from toolkit.reduced_model.parts.spin import SPIN_STIFFENING, Spin


@dataclass(frozen=True, eq=False)
class SolidSpin:
    """Spin stiffening of a solid at its nominal design, with its dependence on every parameter."""

    body: DiscreteBody
    matrices: Matrices
    floats: bool
    found: SpinStiffening

    def polynomial(self, spin: Spin, names: list[str]) -> dict[str, Polynomial]:
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
        matrices, values = change.matrices, dict[str, Any](self.body.values)
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


def _motions(nodes: np.ndarray, free: Freedom, ties: Any, floats: bool) -> np.ndarray | None:
    return free.coordinates_of(rigid_motions(nodes), ties) if floats else None
