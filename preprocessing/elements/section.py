"""What the elements are made of: quantities of a section, the parameters that hold them, and monomials of these.

Sections of spatial beams: their areas and second moments as polynomials of their dimensions, and the fibres whose stress is told.

A section lies in the principal axes e_2 and e_3 of its beam, with the centre of its area on the centre line:

    A          area
    B_2, B_3   int y_2^2 dA and int y_3^2 dA as bending meets them: stiffness E B_2 against deflection along e_2
    S_2, S_3   the same as its mass is spread: int rho y_k^2 dA = rho S_k
    J          Saint-Venant's torsion constant
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields
from math import pi, prod
from typing import NamedTuple, Protocol

import numpy as np

from toolkit.foundation.errors import InputError


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

    dimensions: Mapping[str, complex]  # that may carry a complex step
    flexibility: complex  # E / (kappa G) = 2 (1 + nu) / kappa, that may, too

    @property
    def stepped(self) -> bool:
        """Whether one of the section's dimensions carries a complex step."""
        return bool(np.any(np.imag([*self.dimensions.values(), self.flexibility])))

    def phi(self, second_moment: complex, area: complex, lengths: np.ndarray) -> np.ndarray:
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
    number: complex  # where a parameter makes a complex step that the factors do not know


def monomial(values: Mapping[str, complex], factors: Monomial) -> complex:
    """Value of prod_j p_j ** e_j; real or complex, as the values are."""
    return prod(values[name] ** power for name, power in factors)


def monomial_derivative(values: Mapping[str, complex], factors: Monomial, parameter: str) -> complex:
    """Derivative e_i p_i ** (e_i - 1) prod_j p_j ** e_j, j != i, by the parameter p_i."""
    lowered = tuple((name, power - (name == parameter)) for name, power in factors)
    return dict(factors).get(parameter, 0) * monomial(values, lowered)


class Term(NamedTuple):
    """One summand of a polynomial: a number times powers of the section's dimensions."""

    number: complex
    powers: Mapping[str, int]  # dimension -> power


Terms = tuple[Term, ...]
ONE: Terms = (Term(1.0, {}),)
SERIES = {0: 1 / 3, 1: -0.21008296, 5: 0.02589027, 7: -0.00856364}
"""Power of the ratio of the sides -> its factor in the torsion constant of a rectangle."""


class Fibre(NamedTuple):
    """Fibre of a section whose stress the model gives: its place and its side."""

    second: Terms  # y_2
    third: Terms  # y_3
    side: int  # +1 where y_2 is negative: the outer side of a skin; else -1


@dataclass(frozen=True)
class SectionShape:
    """Polynomials of one section."""

    area: Terms
    bending_2: Terms
    bending_3: Terms
    spread_2: Terms
    spread_3: Terms
    torsion: Terms
    fibres: tuple[Fibre, ...]

    def fixed(self, dimensions: Mapping[str, complex]) -> SectionShape:
        """Section at numbers of the dimensions, so that none is left in its polynomials."""
        own = {field.name: fixed(getattr(self, field.name), dimensions) for field in fields(self) if field.name != "fibres"}
        fibres = (Fibre(fixed(each.second, dimensions), fixed(each.third, dimensions), each.side) for each in self.fibres)
        return SectionShape(**own, fibres=tuple(fibres))

    def values(self, dimensions: Mapping[str, complex]) -> dict[str, complex]:
        """Values of A, B_2, B_3, S_2, S_3 and J by their names for numbers of the dimensions, real or complex."""
        return {field.name: value_of(getattr(self, field.name), dimensions) for field in fields(self) if field.name != "fibres"}


def value_of(terms: Terms, dimensions: Mapping[str, complex]) -> complex:
    """The polynomial for numbers of the dimensions."""
    total: complex = 0.0
    for number, powers in terms:
        for name, power in powers.items():
            number = number * dimensions[name] ** power
        total = total + number
    return total


def fixed(terms: Terms, dimensions: Mapping[str, complex]) -> Terms:
    """The polynomial at numbers of the dimensions: one number, or none where there is no term."""
    return (Term(value_of(terms, dimensions), {}),) if terms else ()


def strip(thickness: str = "thickness", width: str = "width") -> SectionShape:
    """Section of a skin: a rectangle, thickness along e_2 in the plane of the skin and width along e_3 across it.

    A = t b, B_2 = b t^3 / 12, B_3 = t b^3 / 12, J as of a `rectangle`, and the mass on the middle line of the rectangle, S_2 = 0 and
    S_3 = t b^3 / 12: so bending in the plane has no rotary inertia, as planar beams without it, and torsion has rho t b^3 / 12.
    """
    whole = rectangle(thickness, width)
    return SectionShape(**{**vars(whole), "spread_2": ()})


def rectangle(thickness: str = "thickness", width: str = "width", thin: bool = True) -> SectionShape:
    """Rectangular section, thickness along e_2, width along e_3.

    The smaller of them stands first in J: `thin` says whether it is the thickness.

    A = t b, B_2 = S_2 = b t^3 / 12, B_3 = S_3 = t b^3 / 12, and Saint-Venant's series for J as a polynomial of the ratio r = t / b,

        J = b t^3 (1/3 - 0.210083 r + 0.025890 r^5 - 0.008564 r^7),

    which has the limit and the slope of the thin strip, 192 zeta(5) / pi^5 = 0.630249 = 3 * 0.210083, and of the square both J and its
    derivatives by t and b, which are equal. It is off by less than 0.23 % for r < 1, and by 0.4 % up to r = 1.2.
    """
    short, long = (thickness, width) if thin else (width, thickness)
    second, third = (Term(1 / 12, {width: 1, thickness: 3}),), (Term(1 / 12, {thickness: 1, width: 3}),)
    corners = tuple(
        Fibre((Term(-side / 2, {thickness: 1}),), (Term(across / 2, {width: 1}),), side) for side in (1, -1) for across in (-1, 1)
    )
    torsion = tuple(
        Term(number, {long: 1 - power, short: 3 + power} if power != 1 else {short: 4}) for power, number in SERIES.items()
    )
    return SectionShape((Term(1.0, {thickness: 1, width: 1}),), second, third, second, third, torsion, corners)


def circle(diameter: str = "diameter") -> SectionShape:
    """Circular section: A = pi d^2 / 4, all second moments pi d^4 / 64, J = pi d^4 / 32."""
    second = (Term(pi / 64, {diameter: 4}),)
    torsion = (Term(pi / 32, {diameter: 4}),)
    return SectionShape((Term(pi / 4, {diameter: 2}),), second, second, second, second, torsion, _round(diameter))


def tube(diameter: str = "diameter", wall: str = "wall") -> SectionShape:
    """Circular tube: a circle of the outer diameter d without that of d - 2 w, w the thickness of the wall."""
    second = _without_core(1 / 64, diameter, wall)
    area = (Term(pi, {diameter: 1, wall: 1}), Term(-pi, {wall: 2}))
    return SectionShape(area, second, second, second, second, _without_core(1 / 32, diameter, wall), _round(diameter))


def _without_core(factor: float, diameter: str, wall: str) -> Terms:
    """Terms of factor pi (d^4 - (d - 2 w)^4)."""
    expansion = {(3, 1): 8, (2, 2): -24, (1, 3): 32, (0, 4): -16}
    return tuple(Term(factor * pi * number, {diameter: d, wall: w} if d else {wall: w}) for (d, w), number in expansion.items())


def _round(diameter: str) -> tuple[Fibre, ...]:
    """Eight fibres round the circle; the largest stress of bending about any axis is at most 8 % above that of the largest of them."""
    diagonal = 0.5**0.5
    places = [(1, 0), (diagonal, diagonal), (0, 1), (-diagonal, diagonal)]
    places += [(-y, -z) for y, z in places]
    return tuple(Fibre(_part(y / 2, diameter), _part(z / 2, diameter), 1 if y < 0 else -1) for y, z in places)


def _part(number: float, dimension: str) -> Terms:
    return (Term(number, {dimension: 1}),) if number else ()


def general(fibres: tuple[tuple[float, float], ...] = ((0.0, 0.0),)) -> SectionShape:
    """Section by numbers of another program: `area`, `I_y` = B_3 (bending about e_2), `I_z` = B_2, `J` and `I_p`.

    I_p is the polar moment of the mass.

    S_2 + S_3 = I_p and S_2 - S_3 = I_z - I_y, so that a homogeneous section, I_p = I_y + I_z, has its own.

    Parameters
    ----------
    fibres : (y_2, y_3) of the fibres whose stress is told; by default the centre line
    """
    one, other, half = (Term(1.0, {"I_z": 1}),), (Term(1.0, {"I_y": 1}),), Term(0.5, {"I_p": 1})
    spread_2 = (half, Term(0.5, {"I_z": 1}), Term(-0.5, {"I_y": 1}))
    spread_3 = (half, Term(-0.5, {"I_z": 1}), Term(0.5, {"I_y": 1}))
    places = tuple(Fibre(_constant(y), _constant(z), 1 if y < 0 else -1) for y, z in fibres)
    return SectionShape((Term(1.0, {"area": 1}),), one, other, spread_2, spread_3, (Term(1.0, {"J": 1}),), places)


def _constant(number: float) -> Terms:
    return (Term(number, {}),) if number else ()


class PatchGroup(Protocol):
    """Elements that share quantities apart from the body's."""

    @property
    def elements(self) -> Sequence[int]:
        """Numbers of the first and the last element of the group."""

    @property
    def values(self) -> Mapping[str, float]:
        """Quantities that the group has of its own, with their values."""


@dataclass(frozen=True)
class Parameters:
    """Patches of elements, and the parameters that they take their quantities from."""

    patches: list[Patch]
    values: dict[str, float] = field(default_factory=dict)  # parameter -> value
    quantities: dict[str, str] = field(default_factory=dict)  # parameter -> what it is, for its unit


def distribute(
    body: Mapping[str, float], groups: Mapping[str, PatchGroup], separate: Collection[str], n_elements: int
) -> Parameters:
    """Give every element its parameters.

    An element has `thickness_<number>` if thickness is among the quantities `separate`, else `thickness_<group>` if its group has a
    thickness, else `thickness`. A parameter that no element takes does not exist.

    Raises
    ------
    InputError
        A group holds elements that do not exist or belong to another group.
    """
    owner = _owners(groups, n_elements)
    found = Parameters([])
    members: dict[tuple[tuple[str, str], ...], list[int]] = {}
    for element in range(n_elements):
        own_values = groups[owner[element]].values if owner[element] else {}
        names = {}
        for quantity, meaning in QUANTITIES.items():
            own = str(element) if quantity in separate else owner[element] if quantity in own_values else ""
            names[quantity] = f"{quantity}_{own}" if own else quantity
            found.values[names[quantity]] = own_values.get(quantity, body[quantity])
            found.quantities[names[quantity]] = meaning
        members.setdefault(tuple(names.items()), []).append(element)
    found.patches.extend(Patch(np.array(elements), dict(names)) for names, elements in members.items())
    return Parameters(found.patches, _in_order(found.values), _in_order(found.quantities))


def _owners(groups: Mapping[str, PatchGroup], n_elements: int) -> list[str]:
    owner = [""] * n_elements
    for name, group in groups.items():
        first, last = group.elements
        if not 0 <= first <= last < n_elements:
            raise InputError(
                f"{name}: elements from {first} to {last} are not on the skin, whose elements count from 0 to "
                f"{n_elements - 1}. Give the first and the last one in this order."
            )
        for element in range(first, last + 1):
            if owner[element]:
                raise InputError(f"{name}: element {element} belongs to group {owner[element]!r} too. Let each have one group.")
            owner[element] = name
    return owner


def _in_order(named: dict) -> dict:
    """Quantity by quantity, and in each by the first element that takes the parameter."""
    return {name: named[name] for quantity in QUANTITIES for name in named if _quantity(name) == quantity}


def _quantity(parameter: str) -> str:
    return next(quantity for quantity in QUANTITIES if parameter == quantity or parameter.startswith(f"{quantity}_"))
