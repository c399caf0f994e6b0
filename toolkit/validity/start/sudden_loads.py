"""Loads that act in full at t = 0 on a scene that rests without them, and steps that had to be halved, most often because of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.validity.motion.creeping_friction import told_frictions

MOST_NAMED = 3
"""Largest number of loads, and of times, that one sentence names."""


def sudden_loads(scene: Scene) -> list[str]:
    """Names of the loads that a motion meets at t = 0 and whose size is written: forces, torques, pressures, gravity."""
    return [name for name, load in scene.loads.items() if any(_written(load)) and _at_start(load) != 0]


def _written(load) -> Iterator[bool]:
    """Whether each field that a load is proportional to is not zero."""
    return (bool(np.any(np.real(getattr(load, field)) != 0)) for field in load.proportional)


def _at_start(load) -> float:
    """Value of a load's time curve at t = 0; one without a curve."""
    curve = getattr(load, "curve", None)
    return 1.0 if curve is None else float(np.real(curve.evaluate(np.zeros(1))[0, 0]))


def told_loads(scene: Scene, options: RunOptions) -> str:
    """Sentences on loads that begin at once at t = 0; empty where none does, or a motion starts in their equilibrium."""
    names = sudden_loads(scene)
    if not names or options.start != "given" or options.quasi_static:
        return ""
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return (
        f"At t = 0 {', '.join(map(repr, names[:MOST_NAMED]))}{more} {'sets' if len(names) == 1 else 'set'} in at once, with a blow. "
        'solver.start = "equilibrium" begins in the equilibrium under the loads at t = 0; or let them grow by a curve.'
    )


def _padded(solution: Solution) -> np.ndarray:
    """Coordinates (n,) of the start, with zeros for the multipliers."""
    return np.append(np.real(solution.q[0]), np.zeros(solution.system.n - solution.system.n_q))


@check("halved-steps", (MOTION,))
def halved_steps(solution: Solution) -> Iterator[Caution]:
    """Steps in which Newton did not converge, or that threw the joints open, were taken in halves; gradients are those of these steps.

    Limit: any.
    Fix: a smaller `solver.step`; `solver.start = "equilibrium"` or a load curve where loads set in at t = 0; a wider friction.
    """
    if not solution.halved:
        return
    options = solution.options or solution.system.scene.solver
    lengths, count = np.diff(solution.whole_run), len(solution.halved)
    when = ", ".join(f"{time:.4g}" for time in solution.halved[:MOST_NAMED])
    more = f" and {count - MOST_NAMED} more" if count > MOST_NAMED else ""
    why = told_loads(solution.system.scene, options) if solution.halved[0] == 0 and not solution.own_start else ""
    why = told_frictions(solution.system, _padded(solution), float(lengths.max())) or why
    yield halved_steps.caution(
        f"{count} {'step was' if count == 1 else 'steps were'} halved, because Newton did not converge in a whole one: at "
        f"t = {when}{more}. "
        f"{solution.steps} steps were taken, from {lengths.min():.2g} to {lengths.max():.2g}; gradients are those of these steps. "
        f"{why or 'Fix: a smaller solver.step.'}",
        doubt=False,
    )
