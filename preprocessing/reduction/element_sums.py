"""The finite elements of a body one by one, as the reduced model keeps them, with their dependence on every parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from preprocessing.assembly.assembly import Part, assemble
from preprocessing.assembly.invariants import Term, polynomial_of
from preprocessing.basis.reduction import undeformed
from preprocessing.discretisation.discretisation import DesignSpace, Discretisation, derivative_of
from preprocessing.elements.block_element import LineElement
from preprocessing.elements.section import Monomial, monomial
from preprocessing.elements.space import Form
from preprocessing.reduction.stored_entries import ROUND_OFF, joined_rates
from toolkit.reduced_model.dependence import Derivatives, Polynomial
from toolkit.reduced_model.elements import Elements, SpatialElements

KINDS: dict[int, Any] = {2: Elements, 3: SpatialElements}
"""By the dimension of space."""
PLACES = ("nodes", "connectivity", "held")
"""Fields that are no sums."""

Arrays = dict[str, np.ndarray]


class ElementSums(NamedTuple):
    """Elements of a body, and their dependence on the parameters as in `ReducedModel`."""

    elements: Elements | SpatialElements
    derivatives: dict[str, Derivatives]
    affine: dict[str, Polynomial]


def element_sums(space: DesignSpace, nominal: Discretisation, held: Sequence[int]) -> ElementSums:
    """All elements at the nominal design of a body, whose frame is tied to the nodes `held`, or to none."""
    every = _by_monomial(nominal.element)
    mass = _sum(every, space.values)["mass"]
    units = {factors: monomial(space.values, factors) if "mass" in arrays else 1.0 for factors, arrays in every.items()}
    summands = {factors: _significant(arrays, mass / units[factors]) for factors, arrays in every.items()}
    arrays = {"nodes": nominal.nodes, **_sum(summands, space.values)}
    kind = KINDS[nominal.nodes.shape[1]]
    found_by_place = {"connectivity": nominal.element.connectivity, "held": np.array(held, np.int64)}
    places = {f.name: found_by_place[f.name] for f in fields(kind) if f.name in found_by_place}
    elements = kind(**places, **arrays)
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
    scales = {"nodes": np.abs(nominal["nodes"]).max(), **_scales(nominal, nominal["mass"])}
    return {f"elements.{name}": _counting(rate, scales[name]) for name, rate in found.items()}


def _counting(rate: np.ndarray, scale: Any) -> np.ndarray:
    """Zeros in the place of entries that change by round-off of what changes most in parts of its scale."""
    parts = np.divide(np.abs(rate), scale, out=np.zeros(rate.shape), where=np.broadcast_to(scale, rate.shape) > 0)
    return np.where(parts > ROUND_OFF * parts.max(initial=0), rate, 0.0)


def _sum(summands: Mapping[Monomial, Arrays], values: Mapping[str, Any]) -> Arrays:
    """The arrays at values of the parameters."""
    names = list(dict.fromkeys(name for arrays in summands.values() for name in arrays))
    return {
        name: sum(monomial(values, factors) * arrays[name] for factors, arrays in summands.items() if name in arrays)
        for name in names
    }


def _by_monomial(element: LineElement) -> dict[Monomial, Arrays]:
    """Monomial of the parameters -> what it multiplies in every array."""
    apart = element.apart()
    count, local = len(element.connectivity), 2 * element.per_node
    if apart.coordinates.hidden != element.hidden * count:
        raise TypeError(
            f"{type(element).__name__} has hidden coordinates: its `apart` has to give one to every element, as SpatialBeam does."
        )
    xi = undeformed(apart.nodes).reshape(count, local, 1)
    z = np.concatenate([xi, np.broadcast_to(np.eye(local), (count, local, local))], axis=2)
    hidden = np.zeros((count, element.hidden, 1 + local))
    hidden[:, :, 0] = 1
    z = np.concatenate([z, hidden], axis=1)
    found: dict[Monomial, Arrays] = {}
    for part in assemble(apart).parts:
        own = found.setdefault(part.factors, {})
        for name, array in _summands(part, apart, z):
            own[name] = own[name] + array if name in own else array
    return found


def _summands(part: Part, apart: LineElement, z: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """What one part of one matrix adds."""
    local = 2 * apart.per_node
    if part.name == "stress":
        yield "stress_operator", _rows(part.matrix, local)
        return
    blocks = _blocks(part.matrix, apart, z.shape[1])
    if isinstance(part.name, str):
        yield part.name, _symmetric(blocks[:, :local, :local])
    else:
        yield from _of_mass(part.name, blocks, apart, z)


def _of_mass(pair: tuple[int, int], blocks: np.ndarray, apart: LineElement, z: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """What one component mass matrix adds."""
    space = apart.space
    for form in (form for form in space.forms if pair in form.pairs):
        yield form.item, _placed(form, _form(form, blocks, z), len(space.pairs))
    if pair[0] == pair[1]:
        axis = np.zeros(z.shape[1])
        axis[pair[0] : 2 * apart.per_node : apart.per_node] = 1
        row = np.einsum("i,eij,ejz->ez", axis, blocks, z)
        moment = np.zeros((len(z), space.dimension, z.shape[2]), row.dtype)
        moment[:, pair[0]] = row
        yield "first_moment", moment
        if pair[0] == 0:
            yield "mass", np.einsum("i,eij,j->e", axis, blocks, axis)


def _form(form: Form, blocks: np.ndarray, z: np.ndarray) -> np.ndarray:
    if form.part == "antisymmetric":
        moment = _moment(z, blocks - np.swapaxes(blocks, 1, 2))
        return (moment - np.swapaxes(moment, 1, 2)) / 2
    moment = _moment(z, blocks)
    return _symmetric(moment) if form.part == "symmetric" else moment


def _placed(form: Form, moment: np.ndarray, places: int) -> np.ndarray:
    """A moment, as one of several of its element if it has a place among them."""
    if form.place is None:
        return moment
    found = np.zeros((len(moment), places, *moment.shape[1:]), moment.dtype)
    found[:, form.place] = moment
    return found


def _moment(z: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    return np.swapaxes(z, 1, 2) @ (blocks @ z)


def _symmetric(blocks: np.ndarray) -> np.ndarray:
    return (blocks + np.swapaxes(blocks, 1, 2)) / 2


def _blocks(matrix: Any, apart: LineElement, size: int) -> np.ndarray:
    """The blocks (n_e, size, size) of a sparse matrix that has no entries between elements; hidden coordinates are the last."""
    entries, local, nodal = matrix.tocoo(), 2 * apart.per_node, apart.coordinates.nodal
    owner = np.where(entries.row < nodal, entries.row // local, entries.row - nodal)
    row, column = (np.where(each < nodal, each % local, local) for each in (entries.row, entries.col))
    found = np.zeros((len(apart.connectivity), size, size), entries.dtype)
    np.add.at(found, (owner, row, column), entries.data)
    return found


def _rows(matrix: Any, local: int) -> np.ndarray:
    """Rows (n_s, local), each on the coordinates of its own element."""
    entries = matrix.tocoo()
    found = np.zeros((matrix.shape[0], local), entries.dtype)
    np.add.at(found, (entries.row, entries.col % local), entries.data)
    return found


def _significant(arrays: Arrays, mass: np.ndarray) -> Arrays:
    """With zeros in the place of round-off; `mass` of whole elements: what only turns has none of its own."""
    scales = _scales(arrays, mass)
    return {name: np.where(np.abs(array) > ROUND_OFF * scales[name], array, 0.0) for name, array in arrays.items()}


def _scales(arrays: Arrays, mass: np.ndarray) -> Arrays:
    """How large every entry could be, element by element; see `toolkit.reduced_model.entry_scales`."""
    found: Arrays = {name: _of_squares(arrays[name]) for name in ("stiffness", "damping") if name in arrays}
    moments = {name: arrays[name] for name in ("inertia", "gyroscopic", "second_moment") if name in arrays}
    if moments:
        inertia = moments["inertia"] if "inertia" in moments else moments["second_moment"][:, :3].sum(axis=1)
        found |= {
            name: _of_squares(inertia) if each.ndim == 3 else _of_squares(inertia)[:, None] for name, each in moments.items()
        }
        found["mass"] = np.abs(mass)
        diagonal = np.abs(np.einsum("eii->ei", inertia))
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
