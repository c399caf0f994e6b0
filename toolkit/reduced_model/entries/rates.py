"""Derivatives of what a reduced model has at one design by its parameters."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from toolkit.reduced_model.dependence import Derivatives, Polynomial, Slopes
from toolkit.reduced_model.design_point import DesignPoint

NONE = Derivatives(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))


def rates_at(design: DesignPoint, item: str, numbers: Mapping[str, int]) -> Derivatives:
    """Derivatives of an item by parameters: numbers of these, places in the flattened item, and values to be summed by place.

    Parameters
    ----------
    numbers : the wanted parameters, and the number that each shall have in the result

    Raises
    ------
    InputError
        Nothing that was loaded tells a derivative at this design.
    """
    linear, polynomial, slopes = _told(design, item, tuple(numbers.items()))
    if polynomial is None:
        return linear
    found = polynomial.rates(np.real(design.p), slopes)
    return linear + found if len(linear.parameter) else found


def _told(
    design: DesignPoint, item: str, numbers: tuple[tuple[str, int], ...]
) -> tuple[Derivatives, Polynomial | None, Slopes | None]:
    """File's data on an item's derivatives; looked up once for all designs of a kind."""
    known, key = design.model.told, (design.kind, item, numbers)
    if key not in known:
        by_name = dict(numbers)
        wanted = np.array([by_name.get(name, -1) for name in design.model.parameters])
        derivatives, polynomials = design.model.dependence(item)
        polynomial, tangent = (polynomials or {}).get(item), (derivatives or {}).get(item, NONE)
        design.check(item, [int(k) for k in np.unique(tangent.parameter) if wanted[k] >= 0])
        known[key] = tangent.renumbered(wanted), polynomial, polynomial and polynomial.slopes_by(wanted)
    found: tuple[Derivatives, Polynomial | None, Slopes | None] = known[key]
    return found
