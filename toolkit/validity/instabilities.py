"""Losses of stability, which every design is looked at for by itself: growth hangs on small differences, and its effect is exponential."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from toolkit.foundation.verdict import Caution
from toolkit.responses.vibrations.flutter import UNSTABLE
from toolkit.responses.vibrations.growing import growing_vibrations
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.merging_vibrations import merging_vibrations
from toolkit.validity.bodies.compressed.parametric_resonance import parametric_resonance
from toolkit.validity.equilibrium import stays_in_unstable
from toolkit.validity.start.middle_axis import middle_spins
from toolkit.validity.start.undisturbed import undisturbed

CODES = frozenset({UNSTABLE, "middle-axis", "merging-vibrations", "parametric-resonance"})
"""Codes of these cautions."""


def unstable_motions(solution: Solution) -> Iterator[Caution]:
    """Cautions about motions that hold only because nothing disturbs them."""
    yield from [*middle_spins(solution), *stays_in_unstable(solution)] or undisturbed(solution)


def instabilities(solution: Solution, values: Mapping[str, Any]) -> Iterator[Caution]:
    """Cautions about equilibria, motions and vibrations that a small disturbance ends.

    Parameters
    ----------
    values
        Response -> value; vibrations are looked at where they are asked for.
    """
    if solution.steps:
        yield from unstable_motions(solution)
    yield from merging_vibrations(solution)
    yield from parametric_resonance(solution)
    yield from growing_vibrations(solution, values)
