"""What to say about errors by the length of the steps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.verdict import Caution
from toolkit.sensitivity.errors.step_error import StepError

VALUES, GRADIENTS = 0.042, 0.1
"""Estimated errors above which values and gradients are not trusted: estimates are right to a factor of about two."""
WANTED = 0.01
"""Error for which a shorter step is proposed."""
MOST = 3
"""So many numbers are named at the most."""


def step_cautions(found: StepError | None, values: Mapping[str, Any], gradients: Any, options: RunOptions) -> Iterator[Caution]:
    """Doubts about values and gradients that other steps change too much.

    Parameters
    ----------
    found : StepError
        None if no other steps worked.
    values, gradients : dict
        Of the run itself.
    """
    if found is None:
        yield Caution(
            "steps-not-checked",
            "nothing is known about errors by the length of the steps: neither longer nor shorter ones gave a result. Try a smaller "
            "solver.step.",
        )
        return
    wrong = {f: error for f, error in found.values.items() if not error <= VALUES}
    of_values = (
        f"{'; '.join(_told(f, error, values[f], found.other_values[f], found.how) for f, error in _worst(wrong))}{_more(wrong)}."
    )
    if wrong and not found.vibrations:
        yield Caution("steps", f"{of_values} {_remedy(wrong, found, options)}")
    slopes = {(f, x): error for f, each in found.gradients.items() for x, error in each.items() if not error <= GRADIENTS}
    told = [
        _told(f"the derivative of {f} by {x}", error, gradients[f][x], found.other_gradients[f][x], found.how)
        for (f, x), error in _worst(slopes)
    ]
    of_slopes = f"{'; '.join(told)}{_more(slopes)}."
    if slopes and not found.vibrations:
        yield Caution("gradient-steps", f"{of_slopes} {_remedy(slopes, found, options)}")
    if (wrong or slopes) and found.vibrations:
        both = " ".join([*([of_values] if wrong else []), *([of_slopes[0].upper() + of_slopes[1:]] if slopes else [])])
        yield Caution("lost-vibrations" if wrong else "gradient-steps", f"{both} {_against_vibrations(found)}")
    small = {f: error for f, error in found.own_values.items() if f not in wrong and error > VALUES}
    small |= {
        f"the derivative of {f} by {x}": error
        for f, errors in found.own_gradients.items()
        for x, error in errors.items()
        if (f, x) not in slopes and error > GRADIENTS
    }
    if small:
        told = [f"{what} by about {error:.0%}" for what, error in _worst(small)]
        yield Caution(
            "small-numbers",
            f"errors are small against the largest numbers in the motion, but here some are small themselves, and off by more of what they "
            f"are: {'; '.join(told)}{_more(small)}.",
            doubt=False,
        )


def _worst(errors: Mapping[Any, float]) -> list[tuple[Any, float]]:
    """The largest ones, undefined ones first."""
    return sorted(errors.items(), key=lambda item: -np.nan_to_num(item[1], nan=np.inf))[:MOST]


def _told(what: str, error: float, ours: float, other: float, how: str) -> str:
    size = f"about {error:.1%}" if error < 1 else "as much as it is large, or more,"
    there = f"{np.real(other):.5g}" if np.isfinite(other) else "unknown"
    return f"{what} is off by {size} because of the length of the steps: {np.real(ours):.5g} as it is, {there} {how}"


def _more(errors: Mapping[Any, float]) -> str:
    return f" (and {len(errors) - MOST} more)" if len(errors) > MOST else ""


def _remedy(errors: Mapping[Any, float], found: StepError, options: RunOptions) -> str:
    """A step, or an error of a step, that is expected to be short enough."""
    worst = min(1.0, max(np.nan_to_num(error, nan=1.0) for error in errors.values()))
    part = (WANTED / worst) ** (1 / found.order)
    if options.local_error is not None:
        return f"Try solver.local_error = {options.local_error * part**3:.1g} and solver.step = {options.step * part:.1g}, the longest one."
    if options.times is not None:
        return f"Try times whose steps are {1 / part:.2g} times shorter."
    first = ' solver.scheme = "arnold-bruels" is of second order and needs fewer steps.' if found.order == 1 else ""
    return f"Try solver.step = {options.step * part:.1g} or less.{first}"


def _against_vibrations(found: StepError) -> str:
    """What excites them, and what helps."""
    return (
        f"A load that sets in within few periods, or a start out of balance, excites {found.vibrations}, which the scheme takes out where "
        f"steps are longer than about a tenth of the period. Try solver.step = {found.step:.1g}; or, if nothing is to vibrate, let the "
        'load grow slowly, or begin with solver.start = "equilibrium".'
    )
