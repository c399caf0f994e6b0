"""The arrays of a reduced model that follow from the parts of the matrices and a basis: values, derivatives and polynomials."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array, issparse

from preprocessing.assembly.assembly import Matrices, Parts
from preprocessing.assembly.invariants import contract, contract_derivative, polynomials, whole_arrays, with_roots
from preprocessing.reduction.stored_entries import AnyInvariants, derivatives, polynomials_without_round_off, without_round_off
from toolkit.reduced_model.dependence import Derivatives, Polynomial
from toolkit.reduced_model.model import InterfacePoint


class Rate(NamedTuple):
    """Changes by one parameter: of matrices, shapes and other arrays."""

    matrices: Matrices
    z: np.ndarray  # dZ = [dxi, dPsi] (n, 1 + n_f)
    items: Mapping[str, np.ndarray]  # derivatives of arrays besides the invariants


class Contracted(NamedTuple):
    """Invariants with derivatives and polynomials; the fields of `ReducedModel` have the same names."""

    invariants: AnyInvariants
    derivatives: dict[str, Derivatives]
    affine: dict[str, Polynomial]


def contracted(
    parts: Parts,
    matrices: Matrices,
    values: Mapping[str, Any],
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


def _rates(matrices: Matrices, rate: Rate, shapes: Any) -> dict[str, Any]:
    """Derivatives of the invariants, sparse as the shapes are."""
    d_shapes = csr_array(rate.z) if issparse(shapes) else rate.z
    return vars(contract_derivative(matrices, rate.matrices, shapes, d_shapes))
