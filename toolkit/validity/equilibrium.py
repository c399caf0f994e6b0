"""Cautions about an equilibrium: which limit points lie before it, and whether anybody looked."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.foundation.verdict import Caution
from toolkit.system.solution import Solution


def limits_passed(solution: Solution) -> Iterator[Caution]:
    """A path that was followed past limit points: a real structure may be elsewhere."""
    if solution.own_start:
        yield Caution(
            "own-start",
            "the equilibrium was found from that of another design; whether the path from the unloaded state leads to it was not followed.",
            doubt=False,
        )
    path = solution.path
    if path is None or not path.passed_limit:
        return
    passed = "; ".join(f"{each.percent} of the load, {each.coordinate} runs away" for each in path.limit_points)
    others = (
        f" It met {path.unstable_crossings} unstable equilibria under the full load before." if path.unstable_crossings else ""
    )
    yield Caution(
        "snap-through",
        f"this equilibrium lies BEYOND A SNAP-THROUGH. The path from the unloaded state turns back at limit points ({passed}); a real "
        f"structure jumps at the first, and may come to rest elsewhere.{others}",
    )
