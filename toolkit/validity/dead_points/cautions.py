"""What to say about dead points that a motion passes."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from toolkit.foundation.verdict import Caution
from toolkit.system.solution import Solution
from toolkit.validity.dead_points.branches import dead_points


def dead_points_passed(solution: Solution, variables: Collection[str]) -> Iterator[Caution]:
    """A doubt where a step has jumped between two branches, and about derivatives by what opens a dead point; else a remark."""
    found = dead_points(solution)
    jumped, passed = ([each for each in found if each.meets == meets] for meets in (False, True))
    if jumped:
        yield Caution(
            "jumped",
            f"at t = {jumped[0].time:.4g} a step has jumped from one way of assembling the bodies to another, between which the joints "
            "leave no way: lengths that are a little off have opened a dead point. If the bodies are meant to pass it, give lengths that "
            "fit to the last digit; if they are meant to turn over there, much smaller steps.",
        )
    if passed:
        yield Caution(
            "dead-point",
            f"at t = {passed[0].time:.4g} the motion passes a dead point: joints repeat each other there, and bodies could go on in two "
            "ways. It went straight on. With lengths that are a little off they turn over or jam there.",
            doubt=False,
        )
    opened = {name: each.time for each in passed for name in each.opened_by if name in variables}
    if opened:
        yield Caution(
            "gradient-dead-point",
            f"derivatives by {', '.join(opened)} do not exist: with any change of it the dead point at t = {min(opened.values()):.4g} "
            "opens, and bodies turn over or jam there. What is told is the derivative along the branch that this run took.",
        )
