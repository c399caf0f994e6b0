"""Responses of an equilibrium that a scene asks for and a motion does not have."""

from __future__ import annotations

from collections.abc import Iterator

from toolkit.foundation.errors import quoted
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.responses.response import Response
from toolkit.system.solution import Solution


@check("left-out", (MOTION,))
def left_out(solution: Solution) -> Iterator[Caution]:
    """Responses of an equilibrium were left out of a motion.

    Limit: any.
    Fix: `ffrf statics`; or `when = "end"`, for frequencies and damping about the last state.
    """
    asked = solution.system.scene.responses.items()
    names = [name for name, each in asked if isinstance(each, Response) and each.needs_rest]
    if names:
        which = f"{quoted(names)} {'is a response' if len(names) == 1 else 'are responses'}"
        yield left_out.caution(
            f"{which} of an equilibrium, and left out of this motion. {left_out.fix}",
            doubt=False,
        )
