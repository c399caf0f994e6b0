"""Words of a results file: everything that is no array, checked when it is read."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, model_validator
from pydantic.dataclasses import dataclass

Numbers = dict[str, float]


class Variable(BaseModel):
    """A design variable: where it is in the scene, and its value in the run.

    One that drives several numbers also tells which and how.
    """

    model_config = ConfigDict(extra="forbid")
    path: str
    value: float
    of: list[str] | None = None
    factors: list[float] | None = None

    @property
    def shares(self) -> dict[str, float]:
        """Path of every number that it drives -> factor. Raises ValueError if there are not as many of both."""
        paths = self.of or [self.path]
        return dict(zip(paths, self.factors or [1.0] * len(paths), strict=True))


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class SceneRecord:
    """Scene that was solved, so that it can be solved again.

    table : the scene as nested tables, with every value as it was in the run
    sha256 : hash of the scene's file; empty for a scene made in Python
    changes : path -> value that replaced the file's for this run
    directory : folder of the reduced models, from the folder of the results file
    models : path of each reduced model from that folder -> SHA-256 of its file
    text : the scene's file as it was written, which a results file keeps beside the other words
    """

    table: dict[str, Any]
    sha256: str
    changes: dict[str, str]
    directory: str
    models: dict[str, str]
    text: str = ""


class RunWords(BaseModel):
    """Cost of a run, wall times in s, and how well its joints held."""

    model_config = ConfigDict(extra="forbid")
    drift: float
    correction: float
    load_steps: int
    newton_iterations: int
    wall_primal: float | None
    wall_sensitivity: float | None


class VerdictWords(BaseModel):
    """Record of whether the run's numbers were trusted."""

    model_config = ConfigDict(extra="forbid")
    trusted: bool
    reasons: list[str]


class CautionWords(BaseModel):
    """A reason to doubt the numbers of a run, or a remark on what they mean."""

    model_config = ConfigDict(extra="forbid")
    code: str
    text: str


class JudgedWords(BaseModel):
    """Verdict of a run and its reasons, as `Verdict.record` gives it; measured values stand beside it under their names."""

    model_config = ConfigDict(extra="allow")
    verdict: VerdictWords
    warnings: list[CautionWords]


class About(BaseModel):
    """Fields of `Results` that are no arrays, under the same names."""

    model_config = ConfigDict(extra="forbid")
    kind: Literal["transient", "static"]
    method: str
    units: Literal["mm-t-s", "m-kg-s"]
    responses: Numbers
    response_units: dict[str, str]
    gradients: dict[str, Numbers]
    variables: dict[str, Variable]
    run: RunWords
    judged: JudgedWords | None = None
    settings: dict[str, Any]
    writers: dict[str, str]
    bodies: list[str]
    scene: SceneRecord

    @model_validator(mode="after")
    def _names_agree(self) -> Self:
        if set(self.response_units) != set(self.responses):
            raise ValueError("responses and their units have different names")
        if not set(self.gradients) <= set(self.responses):
            raise ValueError("there are gradients of unknown responses")
        if any(set(slopes) != set(self.variables) for slopes in self.gradients.values()):
            raise ValueError("gradients and variables have different names")
        return self
