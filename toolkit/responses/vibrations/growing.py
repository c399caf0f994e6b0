"""Whether vibrations about an equilibrium or a spin grow: a frequency alone does not tell that nothing comes to rest there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.responses.vibrations.flutter import UNSTABLE, unstable_vibrations
from toolkit.responses.vibrations.pencil import Pencil, real_pencil
from toolkit.responses.vibrations.roots import SAME, find_vibration
from toolkit.responses.vibrations.steadiness import free_spin
from toolkit.responses.vibrations.vibration import DampingRatio, Frequency, OfVibration, any_pencil_of
from toolkit.system.solution import Solution

SUSPECT = 1e-4
"""Growth, a part of |s|, from which on a root is found again to all digits: what is below may be round-off of faster ones."""


def growing_vibrations(solution: Solution, values: Mapping[str, Any]) -> Iterator[Caution]:
    """Caution for each kind of vibration response whose vibrations grow: a remark where a negative damping ratio says so itself.

    Of an equilibrium at rest it is said whatever is asked for, with its dampers; and of frequencies without them if they alone keep it.
    """
    responses = solution.system.scene.responses
    wanted = {type(each): each for name, each in responses.items() if name in values and isinstance(each, OfVibration)}
    told = any(value < 0 for name, value in values.items() if isinstance(responses[name], DampingRatio))
    of_state = list(unstable_vibrations(solution, doubt=not told))
    yield from of_state
    if of_state:
        return
    if not (solution.steps or solution.spins):
        wanted = {kind: each for kind, each in wanted.items() if issubclass(kind, Frequency)}
    if not wanted:
        return
    pencil, weights = any_pencil_of(solution), solution.system.weights[: solution.system.n_q]
    for kind, response in wanted.items():
        grows = _fastest_growth(response, solution, pencil, weights)
        if grows is not None:
            how, larger = _without(kind, solution), np.exp(2 * np.pi * grows.real / grows.imag)
            yield Caution(
                UNSTABLE,
                f"a vibration with {grows.imag / (2 * np.pi):.4g} cycles per time about this state{how} grows: after each cycle it is "
                f"{larger:.4g} times as large, so that nothing comes to rest here. The response damping-ratio tells how fast; add damping, "
                "or take less of the load or the speed that drives it.",
                doubt=issubclass(kind, Frequency) or not told,
            )


def _without(kind: type[OfVibration], solution: Solution) -> str:
    """Words saying that frequencies about an equilibrium at rest are undamped; empty for every other response."""
    return "" if solution.spins or solution.steps or not issubclass(kind, Frequency) else ", without dampers,"


def _fastest_growth(response: OfVibration, solution: Solution, pencil: Pencil, weights: np.ndarray) -> complex | None:
    """Root s of the counted vibration that grows fastest for its frequency; None if none grows."""
    counted = real_pencil(response.counting(solution, pencil))
    roots = response.vibrations(solution, pencil, weights)
    suspects = [k + 1 for k, s in enumerate(roots) if s.real > SUSPECT * abs(s) and s.imag > SAME * abs(s)]
    idle = free_spin(solution) if suspects else None
    found = [find_vibration(weights, counted, number, response.slowness, idle).s for number in suspects]
    growing = [s for s in found if s.real > SUSPECT * abs(s) and s.imag > SAME * abs(s)]
    return max(growing, key=lambda s: s.real / abs(s), default=None)
