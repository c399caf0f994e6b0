"""When a method begins anew in variables by the curvature where the search stands, and how far these go at first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolkit.studies.optimization.methods.functions import Method
from toolkit.studies.optimization.search.curvature import LONGEST, Known, Turned, turned

NARROWER, WIDER, REACHES = 0.5, 2.0, (1e-3, 1.0)
"""By what the longest first step is changed where one was too long or was not, and between which bounds."""
MANY = 50
"""Variables above which no method begins anew in other ones, in which bounds are constraints like others."""


class Renewal:
    """The renewals of one search.

    Parameters
    ----------
    curved
        Whether the objective tells its curvature.
    top
        Largest z, (n,).
    """

    def __init__(self, curved: bool, top: np.ndarray) -> None:
        self.curved, self.top = curved, top
        self.reach = LONGEST

    def every(self, method: Method) -> int | None:
        """Designs after which a method begins anew; None if it never does."""
        if len(self.top) > MANY:
            return None
        return method.told if self.curved else method.learned

    def adapt(self, method: Method, used: int) -> None:
        """Go farther, or less far, along the told curvature next time, by the designs that were solved until one was accepted."""
        every = self.every(method) or used
        factor = WIDER if used <= every else NARROWER if used > every + 1 else 1.0
        self.reach = float(np.clip(self.reach * factor, *REACHES)) if self.curved else LONGEST

    def variables(self, method: Method, centre: Known, others: Sequence[Known], multipliers: np.ndarray) -> Turned | None:
        """Variables by the curvature about a design, None where it is not known or the method stays as it is."""
        return None if self.every(method) is None else turned(centre, others, multipliers, self.top, self.reach)
