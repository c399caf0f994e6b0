"""What to say about dead points that a motion passes."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from toolkit.foundation.verdict import Caution, check
from toolkit.system.solution import Solution
from toolkit.validity.dead_points.branches import DeadPoint, dead_points


def dead_points_passed(solution: Solution, variables: Collection[str]) -> Iterator[Caution]:
    """A doubt where a step has jumped between two branches, and about derivatives by what opens a dead point; else a remark."""
    found = dead_points(solution)
    passed = [each for each in found if each.meets]
    yield from jumped([each for each in found if not each.meets])
    yield from straight_on(passed)
    yield from opened(passed, variables)


@check("jumped")
def jumped(found: Sequence[DeadPoint]) -> Iterator[Caution]:
    """A step has jumped from one way of assembling the bodies to another, with no way between them.

    Limit: joints that stay open by more than 1e-9 of the model size.
    Fix: lengths that fit to the last digit, or much smaller steps.
    """
    if found:
        yield jumped.caution(
            f"at t = {found[0].time:.4g} a step has jumped from one way of assembling the bodies to another, between which the joints "
            "leave no way: lengths that are a little off have opened a dead point. Fix: lengths that fit to the last digit, if the bodies "
            "are to pass it; much smaller steps, if they are to turn over there.",
        )


@check("dead-point")
def straight_on(found: Sequence[DeadPoint]) -> Iterator[Caution]:
    """The motion passes a dead point, where bodies could go on in two ways, and went straight on.

    Limit: joints that repeat each other to 1e-5.
    Fix: nothing if it is meant; another way takes lengths that are a little off.
    """
    if found:
        yield straight_on.caution(
            f"at t = {found[0].time:.4g} the motion passes a dead point: joints repeat each other, and bodies could go on in two ways. It "
            "went straight on. With lengths that are a little off they turn over or jam there.",
            doubt=False,
        )


@check("gradient-dead-point")
def opened(found: Sequence[DeadPoint], variables: Collection[str]) -> Iterator[Caution]:
    """Derivatives by what opens a dead point do not exist; what is told is that along the branch that was taken.

    Limit: 1e-3 of what a variable changes at the joints.
    Fix: do not search over such a variable.
    """
    times = {name: each.time for each in found for name in each.opened_by if name in variables}
    if times:
        yield opened.caution(
            f"derivatives by {', '.join(times)} do not exist: any change of it opens the dead point at t = {min(times.values()):.4g}, and "
            "bodies turn over or jam there. What is told is the derivative along the branch that this run took.",
        )
