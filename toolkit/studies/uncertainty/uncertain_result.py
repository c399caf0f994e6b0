"""What follows from uncertain numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.foundation.verdict import Verdict, finite
from toolkit.studies.engine.outcome import DesignOutcome
from toolkit.studies.uncertainty.expansion import Expansion
from toolkit.studies.uncertainty.spread import Spread
from toolkit.studies.uncertainty.uncertain_study import UncertainStudy


@dataclass(frozen=True)
class UncertainResult:
    """Uncertain responses of a study.

    Attributes
    ----------
    study
        The study with the distributions of its numbers.
    responses
        Response, with its case before it where cases have names -> what is known about it.
    expansions
        The same -> polynomial of the germs.
    solved
        Designs with gradients, the first at the means.
    sampled
        Random designs without gradients.
    verdict
        Whether the numbers can be trusted.
    wall
        Time that all designs took, also before an interruption, in s.
    """

    study: UncertainStudy
    responses: Mapping[str, Spread]
    expansions: Mapping[str, Expansion]
    solved: tuple[DesignOutcome, ...]
    sampled: tuple[DesignOutcome, ...]
    verdict: Verdict
    wall: float

    @property
    def failed(self) -> int:
        """How many designs could not be solved."""
        return sum(each.failed for each in (*self.solved, *self.sampled))

    @property
    def said(self) -> str:
        """What it took, as a sentence."""
        random = f" and {len(self.sampled)} random ones without" if self.sampled else ""
        return f"{len(self.solved)} designs with gradients{random}, {self.failed} of which could not be solved, in {self.wall:.1f} s."

    def values(self, response: str, germs: np.ndarray) -> np.ndarray:
        """A response by its polynomial at germs (count, n)."""
        return self.expansions[response].values(germs)

    def record(self) -> dict[str, Any]:
        """The JSON object."""
        joint, names = self.study.joint, self.study.problem.variables
        return {
            "uncertain": {
                "variables": {
                    name: {"mean": each.mean, "sigma": each.sigma} for name, each in zip(names, joint.marginals, strict=True)
                },
                "responses": {name: finite(each.record()) for name, each in self.responses.items()},
            },
            "evaluations": len(self.solved) + len(self.sampled),
            "failed": self.failed,
            "wall_s": self.wall,
            **self.verdict.record(),
        }
