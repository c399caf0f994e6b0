"""The sections of a body's beams as its reduced model keeps them, with their dependence on every parameter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from preprocessing.assembly.invariants import Term, polynomial_of
from preprocessing.discretisation.discretisation import Change, DesignSpace, Discretisation, derivative_of
from preprocessing.elements.block_element import LineElement
from preprocessing.elements.section import SectionTerm, monomial
from preprocessing.reduction.stored_entries import joined_rates
from toolkit.reduced_model.dependence import Derivatives, Polynomial
from toolkit.reduced_model.parts.sections import BeamSections

BY_ELEMENT = ("stress_per_strain", "axial_stiffness", "torsional_stiffness", "shear_stiffness", "mass_per_length")
"""Arrays with one number for each element."""


class KeptSections(NamedTuple):
    """Sections and their dependence on the parameters; the fields of `ReducedModel` have the same names."""

    sections: BeamSections | None = None
    section_derivatives: dict[str, Derivatives] | None = None
    section_affine: dict[str, Polynomial] | None = None


def beam_sections(space: DesignSpace, nominal: Discretisation, changes: Mapping[str, Change]) -> KeptSections:
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


def _sums(element: LineElement, terms: list[SectionTerm], values: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Arrays of the sections at some values of the parameters; complex where the terms make complex steps."""
    n, planes = len(element.connectivity), element.space.dimension - 1
    found = {name: np.zeros((n, 1), complex) for name in BY_ELEMENT}
    found["bending_stiffness"] = np.zeros((n, planes), complex)
    found["fibre_distance"] = np.zeros((len(element.stress_points.element), planes), complex)
    for name, rows, column, factors, number in terms:
        found[name][rows, column] += number * monomial(values, factors)
    return {name: array[:, 0] if name in BY_ELEMENT else array for name, array in found.items()}


def _polynomials(terms: list[SectionTerm], arrays: Mapping[str, np.ndarray], names: list[str]) -> dict[str, Polynomial]:
    by_item: dict[str, list[Term]] = {}
    for name, rows, column, factors, number in terms:
        width = 1 if arrays[name].ndim == 1 else arrays[name].shape[1]
        by_item.setdefault(f"sections.{name}", []).append((factors, width * rows + column, np.full(len(rows), np.real(number))))
    return {item: polynomial_of(each, names) for item, each in by_item.items()}
