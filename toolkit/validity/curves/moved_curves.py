"""Whether the times of a run saw what a change of a curve's times does: a jump that is moved within a step changes nothing that they see.

The derivative of a curve by its start is -f', which is a pulse where the curve is a jump. Values may be right to the step while no run sees
this pulse, so that runs with other steps agree about a derivative of zero.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from toolkit.compilation.quantities import STEP, curves_of
from toolkit.curves.curve import Curve
from toolkit.foundation.units import LABELLED
from toolkit.foundation.verdict import Caution, check
from toolkit.scene.measures import number_measure
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution
from toolkit.validity.curves.load_curves import loss_of

HIDDEN = 0.5
"""Part of a curve's change that may lie between the times of a run: with less, runs with other steps see another part of it."""
TIME = LABELLED["time"]


@dataclass(frozen=True)
class Slope:
    """Derivative of a curve by a variable that is in its numbers as a complex step."""

    curve: Curve
    is_constant = False

    def corners(self) -> tuple[float, ...]:
        """Times of the curve's corners: where its slope jumps, its derivative by the variable jumps."""
        return tuple(np.real(self.curve.corners()))

    def evaluate(self, time: np.ndarray) -> np.ndarray:
        """Derivatives of f, f', f'' at the times, (n_t, 3)."""
        return np.imag(self.curve.evaluate(time)) / STEP


@check("gradient-curve")
def unseen_moves(solution: Solution, variables: Collection[str]) -> Iterator[Caution]:
    """Steps do not see when a curve changes whose times a variable of the design moves.

    Limit: 50 % of what the variable does to the curve.
    Fix: a curve that changes over several steps, or `solver.times` there.
    """
    scene = solution.system.scene
    for name in variables:
        moved = _moved(scene, name)
        for item, curve in curves_of(moved) if moved is not None else ():
            if curve == dict(curves_of(scene))[item]:
                continue
            loss = loss_of(Slope(curve), solution.whole_run)
            if loss is not None and loss.part > HIDDEN:
                yield unseen_moves.caution(
                    f"derivatives by {name} miss {min(loss.part, 1):.0%} (limit {HIDDEN:.0%}) of what it does to {'.'.join(item)}.curve, "
                    f"most near t = {loss.time:.4g}. The curve changes faster there than steps are short. Runs with other steps may miss "
                    f"the same and agree. Fix: a curve that changes over several steps, or steps of {loss.shortest / 10:.2g} there "
                    "(solver.times).",
                )


def _moved(scene: ResolvedScene, variable: str) -> ResolvedScene | None:
    """The scene with a complex step in the times that a variable drives; None if it drives none."""
    moved = None
    for path, factor in zip(scene.paths_of(variable), scene.factors_of(variable), strict=True):
        if path.split(".")[0] in ("joints", "loads") and number_measure(scene, path).dimension == TIME:
            moved = (moved or scene).with_number(path, scene.number(path) + 1j * STEP * factor)
    return moved
