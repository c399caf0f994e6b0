"""The finite elements of a planar body one by one, as the reduced model keeps them, with their dependence on every parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, replace
from typing import Any, NamedTuple

import numpy as np

from preprocessing.assembly.assembly import Part, assemble
from preprocessing.assembly.energies import antisymmetric, symmetric
from preprocessing.assembly.invariants import Term, polynomial_of
from preprocessing.basis.reduction import undeformed
from preprocessing.discretisation.discretisation import DesignSpace, Discretisation, derivative_of
from preprocessing.elements.block_element import LineElement
from preprocessing.elements.section import Monomial, monomial
from preprocessing.reduction.stored_entries import ROUND_OFF, joined_rates
from toolkit.reduced_model.dependence import Derivatives, Polynomial
from toolkit.reduced_model.elements import LOCAL, Elements

AXES = np.tile(np.eye(2, 3), 2)
"""The unit rigid translations of an element, (2, 6)."""

Arrays = dict[str, np.ndarray]


class ElementSums(NamedTuple):
    """Elements of a body, and their dependence on the parameters as in `ReducedModel`."""

    elements: Elements
    derivatives: dict[str, Derivatives]
    affine: dict[str, Polynomial]


def element_sums(space: DesignSpace, nominal: Discretisation) -> ElementSums:
    """All elements at the nominal design of a planar body."""
    summands = {factors: _significant(arrays) for factors, arrays in _by_monomial(nominal.element).items()}
    arrays = {"nodes": nominal.nodes, **_sum(summands, space.values)}
    elements = Elements(connectivity=nominal.element.connectivity, **arrays)
    names = list(space.values)
    terms: dict[str, list[Term]] = {}
    for factors, found in summands.items():
        for item, array in found.items():
            if np.any(array):
                entry = np.flatnonzero(array)
                terms.setdefault(f"elements.{item}", []).append((factors, entry, array.ravel()[entry]))
    rates = {name: _rates(space, name, arrays) for name in names if name not in space.in_monomials}
    return ElementSums(elements, joined_rates(rates, names), {item: polynomial_of(each, names) for item, each in terms.items()})


def _rates(space: DesignSpace, parameter: str, nominal: Arrays) -> Arrays:
    """Derivatives by a parameter of the geometry, without round-off."""
    stepped = space.stepped(parameter)
    found = {"nodes": derivative_of(stepped.nodes + 0j)}
    found |= {name: derivative_of(each + 0j) for name, each in _sum(_by_monomial(stepped.element), space.values).items()}
    scales = {"nodes": np.abs(nominal["nodes"]).max(), **_scales(nominal)}
    return {f"elements.{name}": _counting(rate, scales[name]) for name, rate in found.items()}


def _counting(rate: np.ndarray, scale: Any) -> np.ndarray:
    """Zeros in the place of entries that change by round-off of what changes most in parts of its scale."""
    parts = np.divide(np.abs(rate), scale, out=np.zeros(rate.shape), where=np.broadcast_to(scale, rate.shape) > 0)
    return np.where(parts > ROUND_OFF * parts.max(initial=0), rate, 0.0)


def _sum(summands: Mapping[Monomial, Arrays], values: Mapping[str, Any]) -> Arrays:
    """The arrays at values of the parameters."""
    names = [f.name for f in fields(Elements) if f.name not in ("nodes", "connectivity")]
    return {
        name: sum(monomial(values, factors) * arrays[name] for factors, arrays in summands.items() if name in arrays)
        for name in names
    }


def _by_monomial(element: LineElement) -> dict[Monomial, Arrays]:
    """Monomial of the parameters -> what it multiplies in every array."""
    count = len(element.connectivity)
    torn = replace(
        element,
        nodes=element.nodes[element.connectivity].reshape(-1, element.nodes.shape[1]),
        connectivity=np.arange(2 * count).reshape(-1, 2),
    )
    xi = undeformed(torn.nodes).reshape(count, LOCAL, 1)
    z = np.concatenate([xi, np.broadcast_to(np.eye(LOCAL), (count, LOCAL, LOCAL))], axis=2)
    found: dict[Monomial, Arrays] = {}
    for part in assemble(torn).parts:
        own = found.setdefault(part.factors, {})
        for name, array in _summands(part, z):
            own[name] = own[name] + array if name in own else array
    return found


def _summands(part: Part, z: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """What one part of one matrix adds."""
    if part.name == "stress":
        yield "stress_operator", _rows(part.matrix)
        return
    blocks = _blocks(part.matrix, len(z))
    if isinstance(part.name, str):
        yield part.name, _each(symmetric, blocks)
    elif part.name == (0, 1):
        yield "gyroscopic", _each(antisymmetric, _moment(z, blocks - np.swapaxes(blocks, 1, 2)))
    else:
        axis = part.name[0]
        yield "inertia", _each(symmetric, _moment(z, blocks))
        moment = np.zeros((len(z), 2, 1 + LOCAL), blocks.dtype if np.iscomplexobj(blocks) else z.dtype)
        moment[:, axis] = np.einsum("i,eij,ejz->ez", AXES[axis], blocks, z)
        yield "first_moment", moment
        if axis == 0:
            yield "mass", np.einsum("i,eij,j->e", AXES[0], blocks, AXES[0])


def _moment(z: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    return np.swapaxes(z, 1, 2) @ (blocks @ z)


def _each(part: Any, blocks: np.ndarray) -> np.ndarray:
    return np.stack([part(block) for block in blocks])


def _blocks(matrix: Any, count: int) -> np.ndarray:
    """The blocks (n_e, 6, 6) on the diagonal of a sparse matrix that has no others."""
    entries = matrix.tocoo()
    found = np.zeros((count, LOCAL, LOCAL), entries.dtype)
    np.add.at(found, (entries.row // LOCAL, entries.row % LOCAL, entries.col % LOCAL), entries.data)
    return found


def _rows(matrix: Any) -> np.ndarray:
    """Rows (n_s, 6), each on the coordinates of its own element."""
    entries = matrix.tocoo()
    found = np.zeros((matrix.shape[0], LOCAL), entries.dtype)
    np.add.at(found, (entries.row, entries.col % LOCAL), entries.data)
    return found


def _significant(arrays: Arrays) -> Arrays:
    """With zeros in the place of round-off."""
    scales = _scales(arrays)
    return {name: np.where(np.abs(array) > ROUND_OFF * scales[name], array, 0.0) for name, array in arrays.items()}


def _scales(arrays: Arrays) -> Arrays:
    """How large every entry could be, element by element; see `toolkit.reduced_model.entry_scales`."""
    found: Arrays = {name: _of_squares(arrays[name]) for name in ("stiffness", "damping", "inertia") if name in arrays}
    if "inertia" in arrays:
        found["gyroscopic"] = found["inertia"]
        found["mass"] = np.abs(arrays["mass"])
        diagonal = np.abs(np.einsum("eii->ei", arrays["inertia"]))
        found["first_moment"] = np.sqrt(found["mass"][:, None] * diagonal)[:, None]
    if "stress_operator" in arrays:
        rows = np.abs(arrays["stress_operator"])
        columns = rows.max(axis=0, initial=0)
        parts = np.divide(rows, columns, out=np.zeros(rows.shape), where=columns > 0)
        found["stress_operator"] = parts.max(axis=1, initial=0)[:, None] * columns
    return found


def _of_squares(blocks: np.ndarray) -> np.ndarray:
    root = np.sqrt(np.abs(np.einsum("eii->ei", blocks)))
    return root[:, :, None] * root[:, None, :]
