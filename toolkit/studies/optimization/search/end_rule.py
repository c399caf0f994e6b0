"""When a search is at an optimum: the conditions are met at one design, and the next one is met too or gains nothing that counts.

A method leaves a saddle, where the conditions are met as well, and finds something lower next.
"""

from __future__ import annotations

from toolkit.studies.optimization.optimality import Optimality
from toolkit.studies.study.search_options import Search as SearchOptions

LITTLE = 1e-4
"""Part of an objective by which a lower design that is none is no reason to leave an optimum."""


class EndRule:
    """The rule, told one accepted design after the other.

    Parameters
    ----------
    options
        When the conditions are met.
    curved
        Whether the objective is a mean of squares. Of these what is gained decides alone: a search that is done after a few steps knows
        only steep slopes, beside which all others look small.
    """

    def __init__(self, options: SearchOptions, curved: bool) -> None:
        self.options, self.curved = options, curved
        self.met = False
        self._least: float | None = None

    def ends(self, objective: float, left: Optimality, large: float) -> bool:
        """Whether the search is at an optimum.

        Parameters
        ----------
        objective
            At the design.
        left
            What is left of the conditions there.
        large
            A large change of the objective.
        """
        self.met, least = left.met(self.options.optimality, self.options.feasibility), self._least
        if least is not None and left.violation <= self.options.feasibility:
            counts = min(self.options.optimality * large, LITTLE * abs(least))
            if (self.met and not self.curved) or least - objective <= counts:
                return True
            self._least = None
        if self.met:
            self._least = objective
        return False

    def forget(self) -> None:
        """Begin elsewhere."""
        self.met, self._least = False, None
