"""A scene that several programs integrate, and what each of them made of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np


class DidNotConverge(Exception):
    """A program stopped on its way."""


Motion = Callable[[], np.ndarray]
"""Integrates the scene and returns what is compared; made anew for every repeat, so that building is not counted."""
Maker = Callable[[float], Motion]
"""Makes a scene ready that is integrated with this step."""


@dataclass(frozen=True)
class Contest:
    """One scene with its competitors.

    Attributes
    ----------
    name
        What is integrated.
    quantity
        What is compared, with its unit.
    end_time, step
        In s.
    ours
        This toolkit, by the name of its setting.
    exudyn
        Exudyn, by the name of its setting; the fastest of them counts.
    exact
        The compared quantity, where a closed form gives it. Otherwise every program is judged by its own limit of small steps
        (Richardson's extrapolation from half and a quarter of the step), and the table shows how far these limits are from each other.
    """

    name: str
    quantity: str
    end_time: float
    step: float
    ours: Mapping[str, Maker]
    exudyn: Mapping[str, Maker]
    exact: np.ndarray | None = None


@dataclass(frozen=True)
class Measured:
    """What one setting of one program took and how far off it was."""

    setting: str
    microseconds: float  # per step, the least of the repeats; infinite if the program stopped on its way
    error: float
    limit: np.ndarray  # what it converges to


def measured(contest: Contest, repeats: int) -> tuple[list[Measured], list[Measured]]:
    """Ours and Exudyn's, all settings one after the other in every repeat."""
    makers = [*contest.ours.items(), *contest.exudyn.items()]
    for _, make in makers:  # compiles
        _seconds(make, contest.step)
    spent: dict[str, float] = dict.fromkeys(dict(makers), np.inf)
    for _ in range(repeats):
        for name, make in makers:
            spent[name] = min(spent[name], _seconds(make, contest.step))
    steps = round(contest.end_time / contest.step)
    results = [Measured(name, 1e6 * spent[name] / steps, *_error(contest, make)) for name, make in makers]
    return results[: len(contest.ours)], results[len(contest.ours) :]


def _seconds(make: Maker, step: float) -> float:
    """CPU time of one motion."""
    motion = make(step)
    begun = time.process_time()
    try:
        motion()
    except DidNotConverge:
        return np.inf
    return time.process_time() - begun


def _error(contest: Contest, make: Maker) -> tuple[float, np.ndarray]:
    """How far off the motion is with the contest's step, and what it converges to; not a number if it stops on its way."""
    try:
        whole = make(contest.step)()
        limit = contest.exact if contest.exact is not None else _limit(contest, make)
    except DidNotConverge:
        return np.nan, np.array(np.nan)
    return float(np.abs(whole - limit).max()), limit


def _limit(contest: Contest, make: Maker) -> np.ndarray:
    """Of small steps, by Richardson's extrapolation of a method of second order."""
    half, quarter = (make(contest.step / n)() for n in (2, 4))
    return quarter + (quarter - half) / 3
