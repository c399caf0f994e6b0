"""Rectangular section of one material, and the monomials of its parameters that the beam matrices consist of."""

from __future__ import annotations

from dataclasses import dataclass, fields

Exponents = tuple[int, int, int, int]
"""Powers of (youngs_modulus, density, thickness, width) in one monomial."""

MASS: Exponents = (0, 1, 1, 1)  # rho b t
STRETCHING: Exponents = (1, 0, 1, 1)  # E b t
BENDING: Exponents = (1, 0, 3, 1)  # E b t^3
STRAIN_STRESS: Exponents = (1, 0, 0, 0)  # E
CURVATURE_STRESS: Exponents = (1, 0, 1, 0)  # E t


@dataclass(frozen=True)
class Section:
    """Homogeneous rectangular section, thickness in the plane of the body and width across it."""

    youngs_modulus: float | complex
    density: float | complex
    thickness: float | complex
    width: float | complex


PARAMETERS: tuple[str, ...] = tuple(f.name for f in fields(Section))
"""The design parameters of the reduced model, in the order of `Exponents`."""


def monomial(section: Section, exponents: Exponents) -> float | complex:
    """Value of prod_j p_j ** e_j."""
    product: float | complex = 1.0
    for name, exponent in zip(PARAMETERS, exponents, strict=True):
        product = product * getattr(section, name) ** exponent
    return product


def monomial_derivative(section: Section, exponents: Exponents, parameter: str) -> float | complex:
    """Derivative e_i / p_i prod_j p_j ** e_j by the parameter p_i; the parameters of a section are never zero."""
    exponent = exponents[PARAMETERS.index(parameter)]
    return exponent * monomial(section, exponents) / getattr(section, parameter)
