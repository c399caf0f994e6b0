"""Invariants of a body, their analytical derivatives and their exact polynomials: contractions of theory section 1.

With Z = [xi, Psi], and the products of shapes that `preprocessing.elements.element` states for the plane and for space:

    m      = t_a^T M_aa t_a            N[a, :] = t_a^T M_aa Z          t_a: unit rigid translation along axis a
    plane  G  = Z^T (M_00 + M_11) Z    H       = Z^T (M_01 - M_10) Z
    space  Q_ab = Z^T M_ab Z
    K      = Psi^T K_fe Psi            D       = Psi^T D_fe Psi        stress operator = B Psi

Z is given on the nodal coordinates; what the elements have besides is added here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace

import numpy as np
from scipy.sparse import coo_array, csr_array, issparse, vstack

from preprocessing.elements.element import Coordinates, ElementForm, sparse_of, without_cancelled
from preprocessing.elements.section import Monomial
from preprocessing.reduction.assembly import PARTS, Matrices, MatrixPart, Parts, energies, energy, symmetric
from preprocessing.reduction.stored_entries import AnyInvariants
from toolkit.foundation.value_types import Matrix
from toolkit.reduced_model.dependence import SparsePolynomial


def contract(matrices: Matrices, z: Matrix) -> AnyInvariants:
    """Invariants of a reduced body for Z = [xi, Psi], shape (n, 1 + n_f).

    Those of a sparse Z are sparse too, with all axes but the last one in one; see `whole_arrays`.
    """
    z = matrices.coordinates.undeformed(z)
    psi, t = z[:, 1:], matrices.coordinates.translations[0]
    items = _items(matrices, z, lambda matrix: z.T @ (matrix @ z), lambda matrix: psi.T @ (matrix @ psi))
    return matrices.coordinates.space.invariants(mass=np.asarray(t @ (matrices.m[0] @ t)), **items)


def contract_at(parts: Parts, values: Mapping[str, complex], z: np.ndarray) -> AnyInvariants:
    """Invariants at values of the parameters, with the digits that the roots of the parts keep."""
    return with_roots(contract(parts.at(values), z), parts, values, z)


def with_roots(invariants: AnyInvariants, parts: Parts, values: Mapping[str, complex], z: Matrix) -> AnyInvariants:
    """Invariants with stiffness and damping from the roots of the parts, if these have any."""
    if not any(part.root for part in parts.parts):
        return invariants
    psi = parts.coordinates.undeformed(z)[:, 1:]
    stiffness, damping = (energies(parts, values, name, psi) for name in ("stiffness", "damping"))
    return replace(invariants, stiffness=stiffness, damping=damping)


def whole_arrays(invariants: AnyInvariants, components: int) -> AnyInvariants:
    """Invariants of a sparse Z as arrays with all of their axes; `components` is the number of stresses at a point."""
    axes, width = invariants.first_moment.shape
    shapes: dict[str, tuple[int, ...]] = {"second_moment": (-1, width, width)}
    if axes == 3:
        shapes["stress_operator"] = (-1, components, width - 1)
    dense = {f.name: getattr(invariants, f.name) for f in fields(invariants)}
    dense = {name: value.toarray() if issparse(value) else value for name, value in dense.items()}
    return replace(invariants, **{name: value.reshape(shapes.get(name, value.shape)) for name, value in dense.items()})


def contract_derivative(matrices: Matrices, d_matrices: Matrices, z: Matrix, d_z: Matrix | None = None) -> AnyInvariants:
    """Derivative of `contract` by one design variable, theory section 2.

    The product rule on the derivatives of the matrices, `d_matrices`, and of the basis, `d_z` = [dxi, dPsi] (None: zero); both Z and
    dZ may be sparse.
    """
    by_matrices = contract(d_matrices, z)
    if d_z is None:
        return by_matrices
    z, d_z = matrices.coordinates.undeformed(z), matrices.coordinates.displacement(d_z)
    psi, d_psi = z[:, 1:], d_z[:, 1:]
    by_basis = _items(matrices, d_z, lambda matrix: both_sides(matrix, z, d_z), lambda matrix: both_sides(matrix, psi, d_psi))
    return replace(by_matrices, **{name: getattr(by_matrices, name) + value for name, value in by_basis.items()})


Product = Callable[[csr_array], Matrix]
"""Product of a matrix with shapes on both sides."""


def _items(matrices: Matrices, z: Matrix, of_mass: Product, of_stiffness: Product) -> dict[str, Matrix]:
    """All invariants but the mass: those linear in Z, and products of shapes."""
    space, translations = matrices.coordinates.space, matrices.coordinates.translations
    diagonal = matrices.m[: space.dimension]
    return {
        "first_moment": np.stack([t @ (matrix @ z) for t, matrix in zip(translations, diagonal, strict=True)]),
        **_moments(matrices, of_mass),
        "stiffness": symmetric(of_stiffness(matrices.stiffness)),
        "damping": symmetric(of_stiffness(matrices.damping)),
        "stress_operator": space.by_point(matrices.stress @ z[:, 1:], matrices.components),
    }


def _moments(matrices: Matrices, product: Product) -> dict[str, Matrix]:
    space, found = matrices.coordinates.space, dict[str, list[Matrix]]()
    by_pair = dict(zip(space.pairs, matrices.m, strict=True))
    for form in space.forms:
        first, *others = (by_pair[pair] for pair in form.pairs)
        moment = _moment(form, sum(others, first), product)
        found.setdefault(form.item, []).append(moment)
    ordered = {form.item for form in space.forms if form.place is not None}
    return {item: _after_each_other(each) if item in ordered else each[0] for item, each in found.items()}


def _after_each_other(each: list[Matrix]) -> Matrix:
    return vstack(each, format="csr") if issparse(each[0]) else np.stack(each)


def _moment(form: ElementForm, matrix: csr_array, product: Product) -> Matrix:
    return PARTS[form.part](product(matrix - matrix.T if form.part == "antisymmetric" else matrix))


def polynomials(parts: Parts, parameters: Sequence[str], z: np.ndarray, computed: bool = True) -> dict[str, SparsePolynomial]:
    """Exact dependence of every invariant on the parameters, for a constant Z (n, 1 + n_f).

    The contractions are linear in the matrices, so every part of the matrices gives one term of those invariants that it enters;
    invariants that are zero at every design have no polynomial. Of shapes that were `computed`, not selected, all entries are
    told, zero or not.
    """
    factor = parts.coordinates.undeformed(z if computed else csr_array(z))
    terms: dict[str, list[Term]] = {f.name: [] for f in fields(parts.coordinates.space.invariants)}
    for part in parts.parts:
        for name, contraction in _contractions(part, factor, parts.coordinates):
            found = whole(contraction)
            if np.any(found.data):
                terms[name].append((part.factors, np.ravel_multi_index(found.coords, found.shape), found.data))
    return {name: polynomial_of(found, list(parameters)) for name, found in terms.items() if found}


Term = tuple[Monomial, np.ndarray, np.ndarray]
"""A monomial, places in the flattened invariant, and the coefficients there."""


def polynomial_of(terms: list[Term], parameters: list[str]) -> SparsePolynomial:
    """Polynomial of a list of terms, in the numbers of the parameters."""
    width = max(len(factors) for factors, _, _ in terms)
    factor, power = np.full((len(terms), width), -1), np.zeros((len(terms), width), np.int64)
    for k, (factors, _, _) in enumerate(terms):
        for j, (name, exponent) in enumerate(factors):
            factor[k, j], power[k, j] = parameters.index(name), exponent
    numbers = np.repeat(np.arange(len(terms)), [len(entry) for _, entry, _ in terms])
    return SparsePolynomial(
        factor, power, numbers, np.concatenate([entry for _, entry, _ in terms]), np.concatenate([value for _, _, value in terms])
    )


def whole(matrix: Matrix) -> coo_array:
    """Entries of a matrix with their places: all of a dense one, zero or not, and the stored ones of a sparse one."""
    if not isinstance(matrix, np.ndarray):
        return matrix.tocoo()
    places = np.indices(matrix.shape).reshape(2, -1)
    return coo_array((matrix.ravel(), (places[0], places[1])), shape=matrix.shape)


def _contractions(part: MatrixPart, z: Matrix, coordinates: Coordinates) -> Iterator[tuple[str, Matrix]]:
    """Contribution of one part of one matrix to the invariants, for unit parameters and sparse or dense Z."""
    psi = z[:, 1:]
    if part.name == "stress":
        yield "stress_operator", part.matrix @ psi
    elif isinstance(part.name, str):
        yield part.name, energy(part, psi)
    else:
        yield from _of_mass(part.name, sparse_of(part.matrix), z, coordinates)


def _of_mass(pair: tuple[int, int], matrix: csr_array, z: Matrix, coordinates: Coordinates) -> Iterator[tuple[str, Matrix]]:
    """Contribution of one component mass matrix to the invariants."""
    space, t, width = coordinates.space, coordinates.translations, z.shape[1]
    for form in (form for form in space.forms if pair in form.pairs):
        moment = _moment(form, matrix, lambda each: z.T @ (each @ z))
        yield form.item, moment if form.place is None else _at_place(moment, form.place, len(space.pairs))
    if pair[0] == pair[1]:
        axis = pair[0]
        inertia = without_cancelled(matrix.T @ t[axis], abs(matrix).T @ t[axis])  # nothing of what only turns
        row = z.T @ inertia
        yield "first_moment", coo_array((row, (np.full(width, axis), np.arange(width))), shape=(space.dimension, width))
        if axis == 0:
            yield "mass", np.atleast_2d(inertia @ t[0])


def _at_place(moment: Matrix, place: int, places: int) -> coo_array:
    """Matrix as one of several after each other, in one row."""
    found = whole(moment)
    entry = place * found.shape[0] * found.shape[1] + np.ravel_multi_index(found.coords, found.shape)
    shape = (1, places * found.shape[0] * found.shape[1])
    return coo_array((found.data, (np.zeros(len(entry), int), entry)), shape=shape)


def both_sides(matrix: csr_array, z: Matrix, d_z: Matrix) -> Matrix:
    """Derivative dZ^T M Z + Z^T M dZ of a product of shapes."""
    return d_z.T @ (matrix @ z) + z.T @ (matrix @ d_z)
