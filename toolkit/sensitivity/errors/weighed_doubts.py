"""Energy that the steps took or created, weighed by what was asked for: whether it goes away with shorter steps, as errors of values do.

A comparison of values with those of shorter steps tells how wrong they are, unless both runs lack the same: a vibration that steps damp
away takes its energy with it in both. Then the defect of the energy stays what it is; where the scheme merely errs, it falls with the order
p of the scheme,

    E(h / 2) = E(h) / 2^p
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from toolkit.analyses.transient import simulate
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.sensitivity.errors.step_cautions import VALUES
from toolkit.sensitivity.errors.step_error import StepError, first_order, shorter_steps
from toolkit.system.solution import Solution
from toolkit.validity.motion.created_energy import energy_defects
from toolkit.validity.motion.motion import ENERGY

SLOWER = 1.5
"""The defect may fall by so much less than the order says: it is a largest value over time, and steps are not yet short."""


def unless_it_converges(
    cautions: Iterable[Caution], solution: Solution, error: StepError | None, measures: Mapping[str, Any]
) -> Iterator[Caution]:
    """The cautions, with those about energy as remarks where shorter steps tell that values are right and the defect goes away.

    The price is a run with steps half as long, where there is such a doubt.
    """
    told = list(cautions)
    doubted, balance = any(each.code == "energy" for each in told), measures["energy_balance"]
    if not doubted or error is None or not _converges(solution, error, balance):
        yield from told
        return
    yield from (each for each in told if each.code != "energy")
    yield Caution(
        "energy",
        f"{max(balance.values()):.1%} of the largest energy or work came from nowhere or vanished (limit {ENERGY:.0%}), which the "
        f"responses do not feel: with steps half as long this falls as the order of the scheme says, and they are right to "
        f"{max(error.values.values()):.1e} of the largest that they are in the motion.",
        doubt=False,
    )


def _converges(solution: Solution, error: StepError, balance: Mapping[str, float]) -> bool:
    """Whether values are known to be right, and no defect stays."""
    if not error.by_shorter_steps or not max(error.values.values(), default=0.0) <= VALUES:
        return False
    options = solution.options or solution.system.scene.solver
    try:
        halved = energy_defects(simulate(solution.system, shorter_steps(options, solution.whole_run, 2)))
    except ToolkitError:
        return False
    allowed = SLOWER / 2 ** (1 if first_order(options) else 2)
    before = (balance["created"], balance["lost"])
    return all(now <= max(allowed * then, allowed * ENERGY) for now, then in zip(halved, before, strict=True))
