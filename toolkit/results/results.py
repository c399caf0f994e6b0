"""Results: everything that a run found out, as plain arrays with the names of their rows and columns."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from toolkit.foundation.verdict import Caution, Verdict
from toolkit.kept_run.layout import SceneRecord


@dataclass(frozen=True)
class BodyResults:
    """Fields of one flexible body; a derivative's last axis is that of `Results.design`.

    Stress is in the fibre `fibre` (+1 outer, -1 inner) at the end `end` (0 or 1) of element `element`. The shape error is the distance
    of every node to its target; without a target its arrays have no nodes. Of solids in space, whose points belong to no beam, all three
    are -1, and the stress is that of von Mises.
    """

    stress: np.ndarray  # (n_t, n_s)
    dstress: np.ndarray  # (n_t, n_s, n_x)
    element: np.ndarray  # (n_s,)
    end: np.ndarray  # (n_s,)
    fibre: np.ndarray  # (n_s,)
    shape_error: np.ndarray  # (n_t, n_k)
    dshape_error: np.ndarray  # (n_t, n_k, n_x), nan where the distance is zero
    arc_length: np.ndarray  # (n_k,)

    @property
    def stress_points(self) -> list[str]:
        """Names of the columns of `stress`."""
        rows = zip(self.element, self.end, self.fibre, strict=True)
        names = [_stress_point(k, *map(int, row)) for k, row in enumerate(rows)]
        fibres = {
            name: count(1) for name, times in Counter(names).items() if times > 1
        }  # sections in space have several on one side
        return [f"{name} {next(fibres[name])}" if name in fibres else name for name in names]


def _stress_point(column: int, element: int, end: int, fibre: int) -> str:
    if element >= 0:
        return f"element {element}, {'end' if end else 'start'}, {'outer' if fibre > 0 else 'inner'}"
    return f"point {column}"


@dataclass(frozen=True)
class Results:
    """Results of one run, in the units of `units`; `unit` gives the labels.

    Leading d: total derivative by the variables `design`, on the last axis; n_x is zero if none were computed.
    """

    kind: str  # "transient" or "static"
    method: str  # how gradients were computed: "none", "direct", "complex-step", ...
    units: str
    times: np.ndarray  # (n_t,)
    q: np.ndarray  # (n_t, n_q)
    v: np.ndarray
    a: np.ndarray
    multipliers: np.ndarray  # (n_t, n_lam)
    dq: np.ndarray  # (n_t, n_q, n_x)
    dv: np.ndarray
    da: np.ndarray
    dmultipliers: np.ndarray  # (n_t, n_lam, n_x)
    coordinates: list[str]  # names of the columns of q, v, a
    multiplier_names: list[str]
    design: list[str]  # names of the last axis of every derivative
    responses: dict[str, float]
    response_units: dict[str, str]
    gradients: dict[str, dict[str, float]]  # response -> variable -> derivative; empty if none were computed
    bodies: dict[str, BodyResults]
    variables: dict[str, dict[str, Any]]  # variable -> its path in the scene and its value
    run: dict[
        str, Any
    ]  # drift, correction, load_steps, newton_iterations as in `Solution`; wall_primal, wall_sensitivity in s or None
    settings: dict[str, Any]  # solver settings
    scene: SceneRecord
    writers: dict[str, str]  # program -> version
    judged: dict[str, Any] | None = None  # `Verdict.record`; None in files of older versions
    path: Path | None = field(default=None, compare=False)

    @property
    def verdict(self) -> Verdict:
        """Whether the numbers can be trusted, as found when they were stored."""
        if self.judged is None:
            return Verdict(
                (Caution("not-judged", "the results were kept by a version that did not judge them: run the scene again."),)
            )
        return Verdict.from_record(self.judged)

    @property
    def label(self) -> str:
        """Name by which messages speak of the results."""
        return repr(self.path.name) if self.path else "the run"

    def column(self, coordinate: str) -> int:
        """Number of a coordinate, for example of "rotation of body 'body2'"."""
        return self.coordinates.index(coordinate)

    def unit(self, quantity: str) -> str:
        """Label of a quantity, for example of "stress"."""
        from toolkit.foundation.units import unit

        return unit(self.units, quantity)
