"""Numbers of frames that were chosen at the numbers of a scene, and leave more than is wanted at others.

The meter of large deformation is too large rather than too small: at other numbers errors are what it finds there, or by the runs that
have chosen, as much less as theirs is.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.system.solution import Solution
from toolkit.validity.bodies.bent_surfaces import geometric_errors
from toolkit.validity.description.frame_number import choices_in

CERTAIN = 2
"""Estimated errors are off by up to this factor: beyond so many times the wanted one it is missed for certain."""


@check("outgrown-frames", STATES)
def outgrown_choices(solution: Solution) -> Iterator[Caution]:
    """Bodies whose number of frames was chosen by an error that this solution exceeds."""
    choices = choices_in(solution.system.scene)
    for body, metered in geometric_errors(solution).items() if choices else ():
        if metered is None or body not in choices or choices[body][1].kept_run:
            continue
        number, choice = choices[body]
        error = metered.relative * (min(choice.error / choice.metered, 1.0) if choice.metered > 0 else 1.0)
        if error > choice.wanted:
            needed = int(np.ceil(number * np.sqrt(error / choice.wanted)))
            yield outgrown_choices.caution(
                f"the number of frames of {body} was chosen at the numbers of the scene as it is written. At these it leaves about "
                f"{error:.1%} of the largest displacement, where a geometric error of {choice.wanted:.3g} is wanted. Fix: write these "
                f"numbers into the scene, so that the number is chosen for them, or frames = {needed}.",
                doubt=error > CERTAIN * choice.wanted,
            )
