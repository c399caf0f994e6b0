"""Constraints that were left out of statics because others imply them at the start: refused where an equilibrium violates them."""

from __future__ import annotations

import numpy as np

from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConvergenceError
from toolkit.foundation.near_ties import first_largest
from toolkit.solvers.closing.openings import told
from toolkit.solvers.static.equilibrium import inputs_at
from toolkit.system.redundant_joints import whole
from toolkit.system.system import System


def refuse_open_joints_left_out(system: System, options: RunOptions, q: np.ndarray) -> None:
    """Refuse an equilibrium q (n,) under the full load, in which a joint that was left out is open.

    Raises
    ------
    ConvergenceError
        Names the joint, with its gap.
    """
    rows = system.plan.dropped
    if not len(rows) or not system.compiled:
        return
    inputs, rest = inputs_at(system, options, 1.0)._replace(joints_only=True), np.zeros_like(q)
    gaps = np.real(whole(system).evaluate(inputs, q, rest, rest, linearize=False).applied)[rows]
    sizes = np.abs(gaps) * system.weights[rows]
    if sizes.max() > options.drift_tolerance:
        worst = first_largest(sizes)
        raise ConvergenceError(
            f"{system.numbering.names[rows[worst]]} was left out because other joints imply it at the start; it is open by "
            f"{told(system, int(rows[worst]), gaps[worst])} in the equilibrium: they do so in the start position alone (a folded or "
            "stretched one), or points, lengths and axes do not fit. Start elsewhere, fix them, or remove the joint that is too much."
        )
