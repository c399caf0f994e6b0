"""The finite elements of a body one by one, as the reduced model keeps them, with their dependence on every parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import NamedTuple

import numpy as np

from preprocessing.elements.beams import LineElement
from preprocessing.elements.element import ElementForm, Pair, without_cancelled
from preprocessing.elements.section import Monomial, SectionTerm, monomial
from preprocessing.reduction.assembly import MatrixPart, Parts
from preprocessing.reduction.chosen_basis import undeformed
from preprocessing.reduction.discretisation import DesignChange, DesignSpace, Discretisation, derivative_of
from preprocessing.reduction.invariants import Term, polynomial_of
from preprocessing.reduction.stored_entries import ROUND_OFF, joined_rates
from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial
from toolkit.reduced_model.parts import BeamSections, Elements, SpatialElements

KINDS: dict[int, type[Elements] | type[SpatialElements]] = {2: Elements, 3: SpatialElements}
"""Class of elements by the dimension of space."""
PLACES = ("nodes", "connectivity", "held")
"""Fields that are no sums."""

Arrays = dict[str, np.ndarray]


class SumRows(NamedTuple):
    """Rows of an array with their numbers along its first axis."""

    numbers: np.ndarray  # (n,), of elements or of stress rows, in their order
    values: np.ndarray  # (n, ...)


class ElementSums(NamedTuple):
    """Elements of a body, and their dependence on the parameters as in `ReducedModel`."""

    elements: Elements | SpatialElements | None = None
    derivatives: dict[str, Derivatives] | None = None
    affine: dict[str, SparsePolynomial] | None = None


def element_sums(space: DesignSpace, nominal: Discretisation, held: Sequence[int]) -> ElementSums:
    """All elements at the nominal design of a body, whose frame is tied to the nodes `held`, or to none."""
    every, lengths = _by_monomial(nominal.element, nominal.parts), _lengths(nominal)
    mass = _sum(every, space.values, lengths)["mass"]
    units = {factors: monomial(space.values, factors) if "mass" in arrays else 1.0 for factors, arrays in every.items()}
    summands = {factors: _significant(arrays, mass / units[factors]) for factors, arrays in every.items()}
    arrays = {"nodes": nominal.nodes, **_sum(summands, space.values, lengths)}
    kind = KINDS[nominal.nodes.shape[1]]
    found_by_place = {"connectivity": nominal.element.connectivity, "held": np.array(held, np.int64)}
    places = {f.name: found_by_place[f.name] for f in fields(kind) if f.name in found_by_place}
    elements = kind(**places, **arrays)
    names, scales = list(space.values), {"nodes": np.abs(arrays["nodes"]).max(), **_scales(arrays, arrays["mass"])}
    rates = {name: _rates(space, name, lengths, scales) for name in names if name not in space.in_monomials}
    polynomials = {item: polynomial_of(each, names) for item, each in _terms(summands).items()}
    return ElementSums(elements, joined_rates(rates, names), polynomials)


def _lengths(nominal: Discretisation) -> dict[str, int]:
    """Lengths of the arrays: number of stress rows for the stress operator, number of elements for all others."""
    return {"stress_operator": nominal.parts.n_stress, "": len(nominal.element.connectivity)}


def _terms(summands: Mapping[Monomial, Mapping[str, SumRows]]) -> dict[str, list[Term]]:
    """Nonzero coefficients of each item, monomial by monomial."""
    terms: dict[str, list[Term]] = {}
    for factors, found in summands.items():
        for item, (numbers, values) in found.items():
            flat = values.reshape(len(numbers), -1)
            if np.any(flat):
                row, column = np.nonzero(flat)
                terms.setdefault(f"elements.{item}", []).append(
                    (factors, numbers[row] * flat.shape[1] + column, flat[row, column])
                )
    return terms


def _rates(space: DesignSpace, parameter: str, lengths: Mapping[str, int], scales: Mapping[str, np.ndarray]) -> Arrays:
    """Derivatives by a parameter of the geometry, without round-off."""
    stepped = space.stepped(parameter)
    found = {"nodes": derivative_of(stepped.nodes + 0j)}
    arrays = _sum(_by_monomial(stepped.element, stepped.changing_parts), space.values, lengths)
    found |= {name: derivative_of(each + 0j) for name, each in arrays.items()}
    return {f"elements.{name}": _counting(rate, scales[name]) for name, rate in found.items()}


def _counting(rate: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Derivatives with zeros in place of entries that are round-off of the largest relative change."""
    parts = np.divide(np.abs(rate), scale, out=np.zeros(rate.shape), where=np.broadcast_to(scale, rate.shape) > 0)
    return np.where(parts > ROUND_OFF * parts.max(initial=0), rate, 0.0)


def _sum(summands: Mapping[Monomial, Mapping[str, SumRows]], values: Mapping[str, complex], lengths: Mapping[str, int]) -> Arrays:
    """Arrays of the elements at values of the parameters."""
    found: Arrays = {}
    kind = np.result_type(float, *(rows.values for arrays in summands.values() for rows in arrays.values()))
    for factors, arrays in summands.items():
        unit = monomial(values, factors)
        for name, (numbers, rows) in arrays.items():
            if name not in found:
                found[name] = np.zeros((lengths.get(name, lengths[""]), *rows.shape[1:]), kind)
            found[name][numbers] += unit * rows
    return found


def _by_monomial(element: LineElement, parts: Parts) -> dict[Monomial, dict[str, SumRows]]:
    """Coefficients of each monomial of the parameters in every array."""
    count, local = element.connectivity.shape[0], 2 * element.per_node
    xi = undeformed(element.ends.reshape(-1, element.nodes.shape[1])).reshape(count, local, 1)
    z = np.concatenate([xi, np.broadcast_to(np.eye(local), (count, local, local))], axis=2)
    hidden = np.zeros((count, element.hidden, 1 + local))
    hidden[:, :, 0] = 1
    z = np.concatenate([z, hidden], axis=1)
    found: dict[Monomial, dict[str, list[SumRows]]] = {}
    for part in parts.parts:
        own = found.setdefault(part.factors, {})
        for name, rows in _summands(part, element, z):
            own.setdefault(name, []).append(rows)
    return {factors: {name: _joined(rows) for name, rows in arrays.items()} for factors, arrays in found.items()}


def _joined(every: list[SumRows]) -> SumRows:
    """Sum of rows at the same numbers."""
    added = np.concatenate([each.values for each in every])
    numbers, where = np.unique(np.concatenate([each.numbers for each in every]), return_inverse=True)
    found = np.zeros((len(numbers), *added.shape[1:]), added.dtype)
    np.add.at(found, where, added)
    return SumRows(numbers, found)


def _summands(part: MatrixPart, element: LineElement, z: np.ndarray) -> Iterator[tuple[str, SumRows]]:
    """Contributions of one part of one matrix to the elements' arrays."""
    local, blocks = 2 * element.per_node, part.matrix
    elements = blocks.places.elements
    if part.name == "stress":
        rows = np.zeros((blocks.places.rows.size, local), blocks.values.dtype)
        rows[:, : blocks.values.shape[2]] = blocks.values.reshape(len(rows), -1)
        yield "stress_operator", SumRows(blocks.places.rows.ravel(), rows)
    elif isinstance(part.name, str):
        whole = np.zeros((len(elements), local, local), blocks.values.dtype)
        width = min(local, blocks.values.shape[1])
        whole[:, :width, :width] = blocks.values[:, :width, :width]
        yield part.name, SumRows(elements, _symmetric(whole))
    else:
        for name, values in _of_mass(part.name, blocks.values, element, z[elements, : blocks.values.shape[1]]):
            yield name, SumRows(elements, values)


def _of_mass(pair: Pair, blocks: np.ndarray, element: LineElement, z: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Contributions of one component mass matrix, its blocks (n_e, p, p) on the first p rows of the elements' Z."""
    space = element.space
    for form in (form for form in space.forms if pair in form.pairs):
        yield form.item, _placed(form, _form(form, blocks, z), len(space.pairs))
    if pair[0] == pair[1]:
        axis = np.zeros(z.shape[1])
        axis[pair[0] : 2 * element.per_node : element.per_node] = 1
        inertia = axis @ blocks
        if np.isrealobj(blocks):
            inertia = without_cancelled(inertia, axis @ np.abs(blocks))  # nothing of what only turns
        row = inertia[:, None] @ z
        moment = np.zeros((len(z), space.dimension, z.shape[2]), row.dtype)
        moment[:, pair[0]] = row[:, 0]
        yield "first_moment", moment
        if pair[0] == 0:
            yield "mass", inertia @ axis


def _form(form: ElementForm, blocks: np.ndarray, z: np.ndarray) -> np.ndarray:
    if form.part == "antisymmetric":
        moment = _moment(z, blocks - np.swapaxes(blocks, 1, 2))
        return (moment - np.swapaxes(moment, 1, 2)) / 2
    moment = _moment(z, blocks)
    return _symmetric(moment) if form.part == "symmetric" else moment


def _placed(form: ElementForm, moment: np.ndarray, places: int) -> np.ndarray:
    """Moment as one of several of its element, if it has a place among them."""
    if form.place is None:
        return moment
    found = np.zeros((len(moment), places, *moment.shape[1:]), moment.dtype)
    found[:, form.place] = moment
    return found


def _moment(z: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    return np.swapaxes(z, 1, 2) @ (blocks @ z)


def _symmetric(blocks: np.ndarray) -> np.ndarray:
    return (blocks + np.swapaxes(blocks, 1, 2)) / 2


def _significant(arrays: Mapping[str, SumRows], mass: np.ndarray) -> dict[str, SumRows]:
    """Arrays with zeros in place of round-off; `mass` of whole elements, as what only turns has none of its own."""
    own = {name: rows.values for name, rows in arrays.items()}
    scales = _scales(own, mass[arrays["mass"].numbers] if "mass" in arrays else mass)
    return {
        name: SumRows(numbers, np.where(np.abs(values) > ROUND_OFF * scales[name], values, 0.0))
        for name, (numbers, values) in arrays.items()
    }


def _scales(arrays: Arrays, mass: np.ndarray) -> Arrays:
    """Largest possible size of every entry, element by element; see `toolkit.reduced_model.shapes`."""
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


BY_ELEMENT = ("stress_per_strain", "axial_stiffness", "torsional_stiffness", "shear_stiffness", "mass_per_length")
"""Arrays with one number for each element."""


class KeptSections(NamedTuple):
    """Sections and their dependence on the parameters; the fields of `ReducedModel` have the same names."""

    sections: BeamSections | None = None
    section_derivatives: dict[str, Derivatives] | None = None
    section_affine: dict[str, SparsePolynomial] | None = None


def beam_sections(space: DesignSpace, nominal: Discretisation, changes: Mapping[str, DesignChange]) -> KeptSections:
    """Sections at the nominal design and their dependence on the parameters; empty of elements that are no beams.

    Parameters
    ----------
    changes : parameter -> what it changes, at least of those by which the matrices are no polynomials
    """
    element, values = nominal.element, space.values
    if not (terms := [*element.section_terms()]):
        return KeptSections()
    arrays, names = {name: np.real(array) for name, array in _sums(element, terms, values).items()}, list(values)
    steps = {name: change.stepped.element for name, change in changes.items() if name not in space.in_monomials}
    rates = {
        name: {f"sections.{item}": derivative_of(array) for item, array in _sums(each, [*each.section_terms()], values).items()}
        for name, each in steps.items()
    }
    return KeptSections(
        BeamSections(axis=np.real(element.section_axes), **arrays), joined_rates(rates, names), _polynomials(terms, arrays, names)
    )


def _sums(element: LineElement, terms: list[SectionTerm], values: Mapping[str, complex]) -> dict[str, np.ndarray]:
    """Arrays of the sections at some values of the parameters; complex where the terms make complex steps."""
    n, planes = len(element.connectivity), element.space.dimension - 1
    found = {name: np.zeros((n, 1), complex) for name in BY_ELEMENT}
    found["bending_stiffness"] = np.zeros((n, planes), complex)
    found["fibre_distance"] = np.zeros((len(element.stress_points.element), planes), complex)
    for name, rows, column, factors, number in terms:
        found[name][rows, column] += number * monomial(values, factors)
    return {name: array[:, 0] if name in BY_ELEMENT else array for name, array in found.items()}


def _polynomials(terms: list[SectionTerm], arrays: Mapping[str, np.ndarray], names: list[str]) -> dict[str, SparsePolynomial]:
    by_item: dict[str, list[Term]] = {}
    for name, rows, column, factors, number in terms:
        width = 1 if arrays[name].ndim == 1 else arrays[name].shape[1]
        by_item.setdefault(f"sections.{name}", []).append((factors, width * rows + column, np.full(len(rows), np.real(number))))
    return {item: polynomial_of(each, names) for item, each in by_item.items()}
