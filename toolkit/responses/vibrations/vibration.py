"""Frequencies and damping of the vibrations about an equilibrium.

With the static residual's derivative K (by q and lam), the mass M and the damping C, the latter two without multipliers, a vibration is

    (s^2 M + s C + K) u = 0,     w^T (s^2 M + s C + K) = 0
    ds = - w^T (s^2 dM + s dC + dK) u / w^T (2 s M + C) u
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
from pydantic import Field

from toolkit.foundation.errors import InputError
from toolkit.responses.response import Partials, Response
from toolkit.responses.vibrations.pencil import Pencil, pencil_change, pencil_of
from toolkit.responses.vibrations.roots import SAME, find_vibration
from toolkit.system.solution import Solution


class OfVibration(Response):
    """Base of responses of one vibration about an equilibrium.

    Attributes
    ----------
    number
        Which one, from the slowest on.
    """

    number: int = Field(default=1, ge=1, strict=True)

    @property
    def needs_rest(self) -> bool:
        """Always: vibrations about a motion are no modes of it."""
        return True

    @abstractmethod
    def counted(self, damping: np.ndarray) -> np.ndarray:
        """The damping (n, n) that counts."""

    @abstractmethod
    def of(self, s: complex) -> float:
        """The number from s; nan where s is no vibration that counts."""

    def slowness(self, s: complex) -> float:
        """What vibrations are numbered by; nan where s does not count."""
        return abs(s) if np.isfinite(self.of(s)) else np.nan

    @abstractmethod
    def slope(self, s: complex, ds: Any) -> Any:
        """Its change with that of s, (...,) complex, real."""

    def partials(self, solution: Solution) -> Partials:
        """Of the vibration of that number.

        Raises
        ------
        InputError
            There are not so many; or a load has an integral over time, which undamped vibrations do not have.
        SingularSystemError
            The joints leave no motion.
        """
        system, damped = solution.system, bool(np.any(self.counted(np.ones((1, 1)))))
        if len(system.numbering.states) and not damped:
            raise InputError(
                f"{system.numbering.names[system.n_b]} is an integral over time, which undamped vibrations do not have. Ask for "
                "the response damping-ratio instead, or leave the integral out."
            )
        pencil = pencil_of(solution)
        real = Pencil(*(np.real(each) for each in pencil))
        found = find_vibration(system, real._replace(damping=self.counted(real.damping)), self.number, self.slowness)
        s, u, w = found.s, found.right, found.left
        if not found.alone:  # which of both it is nobody knows
            lost = self.of(s) if system.compiled else complex(self.of(s), np.nan)
            return Partials(lost, design=np.full(system.n_x, np.nan))
        step = Pencil(*(np.imag(each) for each in pencil))
        moved = s * s * step.mass + s * self.counted(step.damping) + step.stiffness
        value = self.of(s) + 1j * self.slope(s, -(w @ moved @ u) / found.scale)
        changes = pencil_change(solution, s, u, w, damped=damped)
        by_z, design = (self.slope(s, -each / found.scale) for each in changes)
        n_q = system.n_q
        return Partials(value.real if system.compiled else value, q=by_z[None, :n_q], multipliers=by_z[None, n_q:], design=design)


class Frequency(OfVibration):
    """Frequency of an undamped vibration about an equilibrium, in cycles per time: those of `ffrf modes`. Negative where the equilibrium is
    unstable.
    """

    kind = "frequency"
    quantity = "rate"

    def counted(self, damping: np.ndarray) -> np.ndarray:
        """None."""
        return 0 * damping

    def of(self, s: complex) -> float:
        """Im s of a pair of roots, - Re s where it is real; one of each pair."""
        vibrates = abs(s.imag) >= abs(s.real)
        one = s.imag if vibrates else s.real
        return (one if vibrates else -one) / (2 * np.pi) if one >= 0 else np.nan

    def slowness(self, s: complex) -> float:
        """The frequency, so that what is unstable comes first."""
        return self.of(s)

    def slope(self, s: complex, ds: Any) -> Any:
        """Of the same."""
        return (np.imag(ds) if abs(s.imag) >= abs(s.real) else -np.real(ds)) / (2 * np.pi)


class DampingRatio(OfVibration):
    """Damping of a vibration about an equilibrium, in parts of the critical one: - Re s / |s|. What is damped more than critically does not
    vibrate and is not counted.
    """

    kind = "damping-ratio"
    quantity = "none"

    def counted(self, damping: np.ndarray) -> np.ndarray:
        """All of it."""
        return damping

    def of(self, s: complex) -> float:
        """- Re s / |s| of one of each pair."""
        return -s.real / abs(s) if s.imag > SAME * abs(s) else np.nan

    def slope(self, s: complex, ds: Any) -> Any:
        """Of the same."""
        return -np.real(ds) / abs(s) + s.real * np.real(np.conj(s) * ds) / abs(s) ** 3
