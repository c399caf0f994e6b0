"""What the elements are made of: quantities of a section, the parameters that hold them, and monomials of these."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from typing import Any, NamedTuple

import numpy as np


@dataclass(frozen=True)
class Section:
    """Homogeneous rectangular section, thickness in the plane of the body and width across it, with Rayleigh damping.

    D = damping_mass M + damping_stiffness K.
    """

    youngs_modulus: float
    density: float
    thickness: float
    width: float
    damping_mass: float = 0.0  # 1 / time
    damping_stiffness: float = 0.0  # time


QUANTITIES: dict[str, str] = {
    "youngs_modulus": "stress",
    "density": "density",
    "thickness": "length",
    "width": "length",
    "damping_mass": "rate",
    "damping_stiffness": "time",
}
"""Quantities of a section, and what they are, for their units."""


Monomial = tuple[tuple[str, int], ...]
"""Product of powers of parameters: (name, power) of each."""


@dataclass(frozen=True, eq=False)
class Sheared:
    """Section that shear deforms; its dimensions are numbers, as the functions along its beams are no polynomials of them."""

    dimensions: Mapping[str, Any]  # that may carry a complex step
    flexibility: Any  # E / (kappa G) = 2 (1 + nu) / kappa, that may, too

    @property
    def stepped(self) -> bool:
        """Whether one of the section's dimensions carries a complex step."""
        return bool(np.any(np.imag([*self.dimensions.values(), self.flexibility])))

    def phi(self, second_moment: Any, area: Any, lengths: np.ndarray) -> np.ndarray:
        """Shear parameter Phi = 12 E I / (kappa G A L^2) of elements, (n_e,)."""
        found: np.ndarray = 12 * self.flexibility * second_moment / area / lengths**2
        return found


@dataclass(frozen=True)
class Patch:
    """Elements that take every quantity from the same parameter: `thickness` of the whole body, or `thickness_nose` of a group."""

    elements: np.ndarray  # numbers of the elements
    parameters: Mapping[str, str]  # quantity -> name of the parameter that holds it

    def monomial(self, **powers: int) -> Monomial:
        """Product of powers of this patch's parameters, named by their quantities."""
        return tuple((self.parameters[quantity], power) for quantity, power in powers.items())


class SectionTerm(NamedTuple):
    """One summand of an array of `BeamSections`: a number times powers of a patch's parameters, in some of its rows."""

    name: str  # of the array
    rows: np.ndarray
    column: int  # of an array with two axes, else 0
    factors: Monomial
    number: Any  # complex where a parameter makes a complex step that the factors do not know


def monomial(values: Mapping[str, Any], factors: Monomial) -> Any:
    """Value of prod_j p_j ** e_j; real or complex, as the values are."""
    return prod(values[name] ** power for name, power in factors)


def monomial_derivative(values: Mapping[str, Any], factors: Monomial, parameter: str) -> Any:
    """Derivative e_i p_i ** (e_i - 1) prod_j p_j ** e_j, j != i, by the parameter p_i."""
    lowered = tuple((name, power - (name == parameter)) for name, power in factors)
    return dict(factors).get(parameter, 0) * monomial(values, lowered)
