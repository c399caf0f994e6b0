"""By how much shapes that were left out make frequencies too high."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.responses.pencil import free_pencil
from toolkit.solvers.free_motions import all_frequencies, all_roots, undamped_rates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.reduced.full_scene import reduced_bodies
from toolkit.validity.bodies.reduced.richer_pencil import richer_pencil

TOLD, DOUBTFUL = 0.01, 0.05
"""Parts of a frequency by which it may be too high without a word, and without a doubt."""
NAMED = 10
"""So many frequencies are named one by one; of a longer list the one that is off most is named besides."""


def raised_frequencies(solution: Solution, frequencies: np.ndarray) -> np.ndarray:
    """Parts (n_modes,) by which the lowest frequencies about the last state are too high, in cycles per time; zero of those that do not
    vibrate, inf of those in the place of one that does not."""
    found, vibrating = np.zeros(len(frequencies)), frequencies > 0
    if not vibrating.any() or not reduced_bodies(solution.system.scene):
        return found
    pencil, weights = richer_pencil(solution, 2 * np.pi * frequencies.max())
    reduced = free_pencil(weights, pencil)[1]
    if solution.spins:
        true = all_frequencies(all_roots(*reduced)[0])
    else:
        true = undamped_rates(reduced.stiffness, reduced.mass) / (2 * np.pi)
    true = true[: len(found)][vibrating]
    with np.errstate(divide="ignore"):
        found[vibrating] = frequencies[vibrating] / np.maximum(true, 0.0) - 1
    return found


def cautions_of_raised(solution: Solution, frequencies: np.ndarray) -> Iterator[Caution]:
    """All of the frequencies that are too high."""
    parts = {f"number {k + 1}": float(part) for k, part in enumerate(raised_frequencies(solution, frequencies))}
    high = {name: part for name, part in parts.items() if abs(part) > TOLD}
    if high:
        yield Caution(
            "left-out-shapes",
            "the parts of cut bodies keep some of their modes (modes_per_frame), so that frequencies are too high, or missing: "
            f"{listed_parts(high, 'about')}. Those before {next(iter(high))} are so by less than {TOLD:.0%}. Write larger numbers, or "
            "leave them out.",
            doubt=max(map(abs, high.values())) > DOUBTFUL,
        )


def listed_parts(parts: Mapping[str, float], word: str) -> str:
    """Frequencies, by what they are called, and the parts by which they are too high, in words."""
    first, most = list(parts)[:NAMED], max(parts, key=lambda name: abs(parts[name]))
    told = [f"{name} by {word} {parts[name]:.1%}" for name in (*first, *({most} - {*first}))]
    more = len(parts) - len(told)
    return ", ".join(told) + (f", and {more} more" if more else "")
