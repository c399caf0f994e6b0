"""Frequencies of a scene that spins, over its speed: Campbell's diagram."""

from __future__ import annotations

from collections.abc import Callable, Sequence, Sized
from typing import NamedTuple

import numpy as np

from toolkit.analyses.spinning import solve_spinning, spinning_modes
from toolkit.foundation.errors import ConvergenceError, InputError, SingularSystemError, retold
from toolkit.foundation.listed_names import SHORT
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.system.solution import Solution
from toolkit.system.system import System

MOST = 10_000
"""Speeds of one diagram."""


def refuse_too_many(count: int) -> None:
    """Refuse more speeds than a diagram may have, before they take memory.

    Raises
    ------
    InputError
        There are more than a diagram has.
    """
    if count > MOST:
        raise InputError(f"{SHORT.repr(count)} speeds are more than the {MOST} of one diagram. Ask for fewer.")


class Campbell(NamedTuple):
    """Frequencies in cycles per time and damping in parts of the critical one, in the order of the frequencies at every speed.

    They are those that the frame sees which spins with the scene. Curves that cross change places there. The verdict says at which
    speeds something speaks against them.
    """

    speeds: np.ndarray  # (n_speeds,) in rad/time
    frequencies: np.ndarray  # (n_speeds, n_modes), nan where there are fewer
    damping: np.ndarray  # (n_speeds, n_modes)
    verdict: Verdict = Verdict()

    def __repr__(self) -> str:
        count, modes = self.frequencies.shape
        return f"<Campbell: {modes} frequencies at {count} speeds from {self.speeds.min():g} to {self.speeds.max():g} rad per unit of time>"


def campbell(
    system: System, speeds: Sequence[float], count: int = 6, progress: Callable[[int, int], None] | None = None
) -> Campbell:
    """Modes of the steady states of a scene at several speeds of its driver.

    Parameters
    ----------
    speeds
        In rad/time, not negative; the sense is that of the driver.
    count
        How many frequencies, from the lowest.
    progress
        Called with the speeds done and the speeds in all.

    Raises
    ------
    InputError
        A speed is invalid, or as `solve_spinning`.
    ConvergenceError, SingularSystemError
        As `solve_spinning`; names the speed.
    """
    refuse_too_many(len(speeds) if isinstance(speeds, Sized) else 0)
    wanted = np.asarray(speeds, float)
    if wanted.ndim != 1 or not 1 <= len(wanted) <= MOST or not np.all(np.isfinite(wanted)) or np.any(wanted < 0):
        raise InputError(f"speeds are a list of 1 to {MOST} numbers in rad per unit of time, none of them negative.")
    options = system.scene.solver.model_copy(update={"equilibrium": "spinning"})
    count = min(count, 2 * system.n)
    frequencies, damping = np.full((2, len(wanted), count), np.nan)
    said: dict[str, list[tuple[float, Caution]]] = {}
    known: Solution | None = None
    for k, speed in enumerate(wanted):
        try:
            known = solve_spinning(system, options, float(speed), known)
            found = spinning_modes(known, count)
        except (ConvergenceError, SingularSystemError) as error:
            raise retold(error, f"at {speed:g} rad per unit of time: {error}") from error
        n = len(found.frequencies)
        frequencies[k, :n] = found.frequencies
        damping[k, :n] = np.nan if found.damping is None else found.damping
        for caution in (*found.verdict.warnings, *known.verdict.warnings):
            said.setdefault(caution.code, []).append((float(speed), caution))
        if progress:
            progress(k + 1, len(wanted))
    modes = max(1, int(np.isfinite(frequencies).any(axis=0).sum()))
    return Campbell(wanted, frequencies[:, :modes], damping[:, :modes], Verdict.of(map(_of_all, said.values())))


def _of_all(said: list[tuple[float, Caution]]) -> Caution:
    """One caution for all speeds, with the words of the last doubt, or of the last remark where none is a doubt."""
    doubts = [each for each in said if each[1].doubt] or said
    speeds = sorted({speed for speed, _ in doubts})
    where = f"at {speeds[0]:g}" if len(speeds) == 1 else f"at {len(speeds)} speeds from {speeds[0]:g} to {speeds[-1]:g}"
    speed, worst = doubts[-1]
    return Caution(worst.code, f"{where} rad per unit of time, here at {speed:g}: {worst.text}", worst.doubt)
