"""How a spin stiffens a body of straight elements, and its derivatives by every parameter."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from preprocessing.assembly.assembly import Matrices
from preprocessing.basis.boundary import coordinates_of
from preprocessing.basis.reduction import motions_of_the_frame, per_node
from preprocessing.discretisation.discretisation import STEP, DesignSpace, Discretisation
from preprocessing.reduction.spin_stiffening import SpinStiffening, Spun, without_round_off_of_rate
from preprocessing.reduction.stored_entries import joined_rates
from toolkit.reduced_model.dependence import Derivatives
from toolkit.reduced_model.parts.spin import SPIN_STIFFENING


@dataclass(frozen=True, eq=False)
class LineSpin:
    """Of a body at its nominal design."""

    space: DesignSpace
    nominal: Discretisation
    z: Any
    free: Any  # sparse (n, n^): which nodal coordinates the frame leaves free
    floats: bool
    found: SpinStiffening

    def rates(self, parameter: str, d_z: Any = None) -> dict[str, np.ndarray]:
        """Derivative by one parameter, which changes Z by d_z."""
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
        """Derivatives by parameters that leave Z as it is."""
        names = list(self.space.values)
        return joined_rates({name: self.rates(name) for name in names if name in parameters}, names)


def line_spin(space: DesignSpace, nominal: Discretisation, z: Any, held: Sequence[int], matrices: Matrices) -> LineSpin:
    """Of elements whose frame is tied to the nodes `held`, or floats about mean axes if there are none."""
    n_nodes, each = len(nominal.nodes), per_node(nominal.nodes)
    kept = np.delete(np.arange(each * n_nodes), coordinates_of(held, n_nodes, each))
    free = sparse.eye_array(each * n_nodes, format="csr")[:, kept]
    found = SpinStiffening(_spun(nominal, space.values, matrices, z, free, not held))
    return LineSpin(space, nominal, z, free, not held, found)


def _spun(body: Discretisation, values: Mapping[str, Any], matrices: Matrices, z: Any, free: Any, floats: bool) -> Spun:
    return Spun(body.element, values, matrices, free, z, motions_of_the_frame(body.nodes) if floats else None)
