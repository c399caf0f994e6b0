"""The path of equilibria that led to a static solution: load factors, coordinates, and the limit points on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LimitPoint:
    """Point of the path where the load factor turns back (fold): the equilibrium beyond it is elsewhere, after a snap-through.

    load_factor : part of the load that is reached there
    coordinate : name of the coordinate that moves most there, in parts of the model size (or rad)
    place : number of the point in the arrays of the path
    """

    load_factor: float
    coordinate: str
    place: int

    @property
    def percent(self) -> str:
        """Load factor in percent, in digits enough to tell it from 100."""
        short = f"{100 * self.load_factor:.6g} %"
        return f"{100 * self.load_factor:.12g} %" if short == "100 %" else short


@dataclass(frozen=True)
class StaticPath:
    """Equilibria in the order in which they were found; the last is the static solution.

    `unstable_crossings` counts the equilibria under the full load that the path met before and that are unstable.
    """

    load_factors: np.ndarray  # (n_p,)
    q: np.ndarray  # (n_p, n_q)
    multipliers: np.ndarray  # (n_p, n_lam)
    limit_points: tuple[LimitPoint, ...] = ()
    unstable_crossings: int = 0

    @property
    def passed_limit(self) -> bool:
        """Whether a snap-through lies between the unloaded state and the last one."""
        return bool(self.limit_points)
