"""Layout of a results file: arrays and the axes that have to agree, and all else in words, checked when it is read."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, model_validator
from pydantic.dataclasses import dataclass

from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.files.hdf5 import Content

SCHEMA = "ffrf-results"
SCHEMA_VERSION = 2
READABLE = (1, 2)
"""Versions that can be read: the first kept no verdict."""

STATES = {
    "times": "t",
    "q": "tq",
    "v": "tq",
    "a": "tq",
    "multipliers": "tl",
    "dq": "tqx",
    "dv": "tqx",
    "da": "tqx",
    "dmultipliers": "tlx",
}
"""Arrays of the whole scene and their axes: times, coordinates, multipliers, variables."""

BODY = {
    "stress": "ts",
    "dstress": "tsx",
    "element": "s",
    "end": "s",
    "fibre": "s",
    "shape_error": "tk",
    "dshape_error": "tkx",
    "arc_length": "k",
}
"""Arrays of a flexible body and their axes: times, stress points, nodes with a target, variables."""

NAMES = {"coordinates": "q", "multiplier_names": "l", "design": "x"}
"""Lists of names and the axis that they label."""

TEXTS = ("about", "scene_text")
"""`about` is JSON with everything that is no array; `scene_text` the scene's file as it was."""

UNDEFINED = ("dshape_error",)
"""Arrays that may hold nan: a derivative that does not exist."""


class ResultsFileError(ToolkitError, ValueError):
    """A results file is missing, damaged, foreign or of another schema version."""


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


def array(content: Content, name: str, axes: str, sizes: dict[str, int]) -> np.ndarray:
    """Read numbers whose axes must have the sizes found so far; sizes of new axes are noted. Raises ValueError if they do not."""
    values = content.array(name)
    if values.dtype.kind == "S" or values.ndim != len(axes):
        raise ValueError(f"{name} is {values.dtype} with {values.ndim} axes instead of numbers with {len(axes)}")
    for axis, size in zip(axes, values.shape, strict=True):
        if sizes.setdefault(axis, size) != size:
            raise ValueError(f"{name} has the shape {values.shape}, which does not fit the other arrays")
    if not np.all(np.isfinite(values)) and name.rpartition("/")[2] not in UNDEFINED:
        raise ValueError(f"{name} holds values that are not finite")
    return values


def names(content: Content, name: str, count: int) -> list[str]:
    """Read a list of names of a known length."""
    values = content.array(name)
    if values.dtype.kind != "S" or values.shape != (count,):
        raise ValueError(f"{name} has {values.shape} entries of {values.dtype} instead of {count} names")
    return [item.decode() for item in values.tolist()]


def text(content: Content, name: str) -> str:
    """Text under a name in a file."""
    value = content.array(name)
    if value.dtype.kind != "S" or value.ndim:
        raise ValueError(f"{name} is {value.dtype} with {value.ndim} axes instead of a text")
    return bytes(value[()]).decode()


def damaged(path: Path, problem: str) -> ResultsFileError:
    """Error for a file that cannot be trusted."""
    return ResultsFileError(f"results file {str(path)!r} is damaged or incomplete: {problem}. Run the scene again with --output.")
