"""Whether a run is long enough for its time curves: what begins after its end has no effect, and no word in its numbers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.compilation.quantities import curves_of
from toolkit.curves.curve import Curve, Part
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.system.solution import Solution


@check("idle-curve", (MOTION,))
def idle_curves(solution: Solution) -> Iterator[Caution]:
    """A curve begins to change after the run has ended.

    Limit: any.
    Fix: a later `solver.end_time`.
    """
    end = float(solution.times[-1])
    for (group, name), curve in curves_of(solution.system.scene):
        part = next((each for each in _parts(curve) if each.begin >= end), None)
        where = f"{group}.{name}.curve"
        if part is not None:
            yield _idle(f"{where}.{part.path} takes over at t = {part.begin:g}", end)
        elif not curve.is_constant and (begin := _first_change(curve, solution.whole_run)) is not None:
            yield _idle(f"{where} keeps its first value until t = {begin:g}", end)


def _parts(curve: Curve, path: str = "", shift: float = 0.0) -> Iterator[Part]:
    """Curves within a curve at any depth, with the times of the whole."""
    for part in curve.parts():
        inner = part._replace(path=path + part.path, begin=part.begin + shift)
        yield inner
        yield from _parts(part.curve, f"{inner.path}.", shift + float(np.real(part.shift)))


def _first_change(curve: Curve, times: np.ndarray) -> float | None:
    """The first corner of a curve that has one value over all the run, if that corner lies at its end or later."""
    corners = [float(corner) for corner in np.real(curve.corners()) if corner >= times[-1]]
    values = np.real(curve.evaluate(times)[:, 0])
    return min(corners) if corners and np.all(values == values[0]) else None


def _idle(what: str, end: float) -> Caution:
    return idle_curves.caution(f"{what}, and the run ends at t = {end:g}: it has no effect. {idle_curves.fix}", doubt=False)
