"""Result of a solver: states at all times, their design derivatives, and what the run cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import NeedsDirectError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.system.static_path import StaticPath
from toolkit.system.system import System


@dataclass(frozen=True)
class Solution:
    """States at all times; a static solution has one time. Leading d: total design derivative, design on the last axis.

    Shapes: q, v, a (n_t, n_q), multipliers (n_t, n_lam), dq, dv, da (n_t, n_q, n_x), dmultipliers (n_t, n_lam, n_x).
    `drift` is the largest violation of a joint, `correction` the largest Newton correction that a step was content with, `local_error` the
    largest error that a step is estimated to have made, all relative to the model size (or rad); `load_steps` of a static solution.
    `options` are those of the run; `own_start` says that it did not begin at the scene's start, and `start_moved`
    by how much of the model size (or rad) a given start was moved to close its joints; `run_times` are all times of the run,
    where the solution holds the states of some alone; `path` is the way of a static solution from the unloaded state; `names` are those
    of states that are no times of a run; `halved` are the times at which steps began that Newton could do in halves only;
    `sensitivity_seconds` is the time that its derivatives took, where that was measured. `judge` finds out what speaks against the
    solution, when it is asked for its `verdict`.
    """

    system: System
    times: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    multipliers: np.ndarray
    dq: np.ndarray
    dv: np.ndarray
    da: np.ndarray
    dmultipliers: np.ndarray
    drift: float = 0.0
    correction: float = 0.0
    local_error: float | None = None
    load_steps: int = 0
    options: RunOptions | None = None
    own_start: bool = False
    start_moved: float = 0.0
    run_times: np.ndarray | None = None
    newton_iterations: int = 0
    sensitivity_seconds: float | None = None
    path: StaticPath | None = None
    names: tuple[str, ...] = ()
    halved: tuple[float, ...] = ()
    judge: Callable[[Solution], Verdict] | None = field(default=None, compare=False)

    @classmethod
    def from_padded(cls, system: System, times: np.ndarray, states: tuple[np.ndarray, ...], **report) -> Solution:
        """Solution from arrays q, v, [a; lam] and their derivatives, all padded to n on the second axis."""
        n_q = system.n_q
        q, v, acc, dq, dv, dacc = states
        return cls(
            system, times, q[:, :n_q], v[:, :n_q], acc[:, :n_q], acc[:, n_q:],
            dq[:, :n_q], dv[:, :n_q], dacc[:, :n_q], dacc[:, n_q:], **report,
        )  # fmt: skip

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the solution can be trusted, and why not; found out when it is first asked for."""
        if self.judge is None:
            return Verdict((Caution("not-judged", "nobody has checked these states: they come from no solver of the toolkit."),))
        return self.judge(self)

    @cached_property
    def known(self) -> dict[Any, Any]:
        """Store of what others have found out about the solution, each under a key of its own."""
        return {}

    @property
    def warnings(self) -> tuple[Caution, ...]:
        """Cautions that whoever reads the solution has to know, doubts first."""
        return self.verdict.warnings

    @property
    def steps(self) -> int:
        """Number of time steps of the whole run."""
        return len(self.whole_run) - 1

    @property
    def spins(self) -> bool:
        """Whether the solution is the steady state of a scene that spins."""
        return not self.steps and (self.options or self.system.scene.solver).equilibrium == "spinning"

    @property
    def whole_run(self) -> np.ndarray:
        """Times of the whole run, also of those states that the solution does not hold."""
        return self.times if self.run_times is None else self.run_times

    def derivative(self, state: str) -> np.ndarray:
        """Total design derivative of q, v, a or multipliers, (n_t, ..., n_x).

        Raises
        ------
        NeedsDirectError
            The run did not compute it.
        """
        found: np.ndarray = getattr(self, f"d{state}")
        if found.shape[-1] != self.system.n_x:
            raise NeedsDirectError(f"the run computed no derivatives of {state}, which a response whose length is zero needs")
        return found

    def coordinates(self, body: str) -> slice:
        """Places of a body's coordinates on the second axis of q, v, a; of a cut body those of all its parts."""
        first, written = self.system.numbering.first, self.system.scene.bodies.get(body)
        if isinstance(written, CutBody):
            return slice(first[body], first[body] + written.starts[-1])
        later = [start for start in first.values() if start > first[body]]
        return slice(first[body], min(later, default=self.system.n_q))
