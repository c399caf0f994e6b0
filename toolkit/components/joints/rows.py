"""Rows of joints, in the plane and in space: forms of the poses of two markers, see `poses`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

from toolkit.components.joints.kernels.laws import angle_law
from toolkit.description.description import Scalar

if TYPE_CHECKING:
    from numpy import ndarray

BETWEEN = 6
"""Number of the vector r_a - r_b in the plane, behind r, e_1, e_2 of a and of b."""
RowQuantity = Literal["length", "angle"]
"""Quantity that a row of a constraint measures."""
ROW_QUANTITIES = get_args(RowQuantity)


@dataclass(frozen=True, eq=False)
class Form:
    """constant + sum value * number + sum value * (vector . vector): numbers and vectors of both poses, by their places.

    Forms are added, subtracted, and multiplied by numbers; what is made that way has the same terms whatever the numbers are.
    """

    constant: Scalar = 0.0
    linear: tuple[tuple[int, Scalar], ...] = ()
    pairs: tuple[tuple[int, int, Scalar], ...] = ()

    __array_ufunc__ = None  # numbers of numpy leave the arithmetic to the form

    def __add__(self, other: Form | Scalar) -> Form:
        if not isinstance(other, Form):
            return Form(self.constant + other, self.linear, self.pairs)
        return Form(
            self.constant + other.constant,
            tuple((place, value) for (place,), value in _united([*self.linear, *other.linear])),
            tuple((i, j, value) for (i, j), value in _united([*self.pairs, *other.pairs])),
        )

    __radd__ = __add__

    def __neg__(self) -> Form:
        return self * -1.0

    def __sub__(self, other: Form | Scalar) -> Form:
        return self + -other

    def __rsub__(self, other: Form | Scalar) -> Form:
        return -self + other

    def __mul__(self, factor: Scalar) -> Form:
        linear = tuple((place, value * factor) for place, value in self.linear)
        return Form(self.constant * factor, linear, tuple((i, j, value * factor) for i, j, value in self.pairs))

    __rmul__ = __mul__

    def __truediv__(self, divisor: Scalar) -> Form:
        return self * (1 / divisor)

    @property
    def numbers(self) -> list[Scalar]:
        """Numbers of the form: its constant, the values of its linear terms and those of its pairs."""
        return [self.constant, *(value for *_, value in self.linear), *(value for *_, value in self.pairs)]


@dataclass(frozen=True, eq=False)
class Vector:
    """A sum of vectors of the poses: number of each, place of its first component (-1 if its components are no forms), and factor.

    In the plane the difference of both positions is a vector of its own, `BETWEEN`: products with each of them would cancel far from
    the origin. `position` marks what it is made of.
    """

    parts: tuple[tuple[int, int, Scalar], ...]
    size: int
    position: bool = False

    __array_ufunc__ = None

    def __add__(self, other: Vector) -> Vector:
        found = _united([*self.parts, *other.parts])
        return Vector(tuple((vector, place, factor) for (vector, place), factor in found), self.size)

    def __sub__(self, other: Vector) -> Vector:
        if self.position and other.position and self is not other:
            return Vector(((BETWEEN, BETWEEN, 1.0 if self.parts[0][0] == 0 else -1.0),), self.size)
        return self + other * -1.0

    def __mul__(self, factor: Scalar) -> Vector:
        return Vector(tuple((vector, place, value * factor) for vector, place, value in self.parts), self.size)

    __rmul__ = __mul__

    def __getitem__(self, c: int) -> Form:
        """Component of the vector along a coordinate axis, as a form."""
        if any(place < 0 for _, place, _ in self.parts):
            raise TypeError("components of axes in the plane are no forms: take the scalar product with another vector")
        return Form(linear=tuple((place + c, factor) for _, place, factor in self._ends))

    @property
    def _ends(self) -> tuple[tuple[int, int, Scalar], ...]:
        """Parts of the vector, with both positions in the place of their difference."""
        found = [[part] if part[0] != BETWEEN or self.size > 2 else [(0, 0, part[2]), (3, 3, -part[2])] for part in self.parts]
        return tuple(part for each in found for part in each)

    def __matmul__(self, other: Vector | Sequence[Scalar] | ndarray) -> Form:
        """Scalar product with a vector of the poses or with numbers, as a form."""
        if not isinstance(other, Vector):
            return sum((self[c] * other[c] for c in range(self.size)), Form())
        mixed = self.position or other.position
        own, others = (self._ends, other._ends) if mixed else (self.parts, other.parts)
        pairs = [(min(i, j), max(i, j), x * y) for i, _, x in own for j, _, y in others]
        return Form(pairs=tuple((i, j, value) for (i, j), value in _united(pairs)))


def _united(terms: Iterable[tuple]) -> list[tuple[tuple, Scalar]]:
    """Terms with those of the same places united to one, in the order in which they come up first."""
    found: dict[tuple, Scalar] = {}
    for *places, value in terms:
        found[tuple(places)] = found[tuple(places)] + value if tuple(places) in found else value
    return list(found.items())


@dataclass(frozen=True, eq=False)
class Row:
    """One constraint: form = 0, or law(form, form, ...) = 0. A time curve is subtracted from a joint's last row.

    Attributes
    ----------
    quantity
        "length" or "angle", in which the cosine of two axes that are normal to each other counts.
    form
        What is zero; or all that a law takes. A number is a form too.
    law
        An open formula, see `kernels.laws`: what no form is, such as an angle in space, a screw, a cam.
    """

    name: str
    quantity: RowQuantity
    form: Form | tuple[Form | Scalar, ...]
    law: Any = None

    @property
    def forms(self) -> tuple[Form, ...]:
        """Forms of the row, all that its law takes."""
        given = self.form if isinstance(self.form, tuple) else (self.form,)
        return tuple(each if isinstance(each, Form) else Form(each) for each in given)


def angle(name: str, cosine: Form, sine: Form) -> Row:
    """Row of atan2(sine, cosine) = 0, taken next to the curve that it follows."""
    return Row(name, "angle", (cosine, sine), angle_law)


def forms_of(rows: Iterable[Row]) -> list[Form]:
    """Forms of all rows of a joint, in order."""
    return [form for row in rows for form in row.forms]


def row_numbers(rows: Iterable[Row]) -> list[Scalar]:
    """Numbers of all forms of all rows, in order."""
    return [number for form in forms_of(rows) for number in form.numbers]
