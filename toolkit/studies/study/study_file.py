"""Contents of a study file: a scene, its variables or uncertain numbers, and what is wanted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from toolkit.description.description import Description, FileName, NotNegative, Number, Pair, Positive, Registered
from toolkit.description.design import check_shares
from toolkit.description.quantity import Quantity
from toolkit.studies.distributions.uncertain_numbers import Uncertain, Uncertainty
from toolkit.studies.study.search_options import Search
from toolkit.studies.study.sweep_options import Sweep

LOAD_MARGIN = "load_margin"
"""A response that every study of statics has: the load factor of the first limit point."""


class StudyVariable(Description):
    """A number of the scene that may change, or several that one variable moves.

    Attributes
    ----------
    between
        Least and largest value.
    of
        Paths of numbers of one unit that the variable moves: its value is by how much, 0 where the scene stands. Without it the variable
        is the number that its own name leads to, a path or a short name of the scene.
    factors
        Of each of these numbers: by how much it moves where the variable moves by one. All are one by default.
    scale
        What a large change of it is; by default its whole range.
    """

    between: Pair
    of: tuple[str, ...] | None = Field(default=None, min_length=1)
    factors: tuple[Number, ...] | None = None
    scale: Positive | None = None

    @model_validator(mode="after")
    def _fit(self) -> Self:
        low, high = self.between
        if low >= high:
            raise ValueError(
                f"between = [{low:g}, {high:g}] holds nothing; write the smaller bound first, and the larger one second"
            )
        check_shares(self.of, self.factors)
        return self


class Limit(Description):
    """What a response must keep to, in every case.

    Attributes
    ----------
    below, above
        Largest and least value.
    between
        Both of them.
    scale
        What a large change of the response is; by default the size of the limit, or 1 if that is zero.
    robust
        By how many standard deviations beside its mean over the numbers of [uncertain] the response must keep to it. Without, the limit
        is kept where these numbers are at their means.
    """

    below: Number | None = None
    above: Number | None = None
    between: Pair | None = None
    scale: Positive | None = None
    robust: Annotated[Positive | None, Quantity("none")] = None

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if self.between is not None and (self.below is not None or self.above is not None):
            raise ValueError("`between` says both limits; leave out `below` and `above`")
        low, high = self.limits
        if low is None and high is None:
            raise ValueError("a constraint needs a limit: `below`, `above` or `between`")
        if low is not None and high is not None and low >= high:
            raise ValueError(
                f"nothing is above {low:g} and below {high:g}: these limits contradict each other. Exchange or fix them"
            )
        return self

    @property
    def limits(self) -> tuple[float | None, float | None]:
        """Least and largest value of the limit; None where there is no limit."""
        return self.between if self.between is not None else (self.above, self.below)


def _weighted(value: Any) -> Any:
    """Weights of an objective; a response alone has the weight one."""
    return {value: 1.0} if isinstance(value, str) else value


Weights = Annotated[
    dict[str, Number] | None,
    BeforeValidator(_weighted),
    WithJsonSchema(
        {"anyOf": [{"type": "string"}, {"type": "object", "additionalProperties": {"type": "number"}, "minProperties": 1}]}
    ),
]


class Objective(Description):
    """What is to be as small, or as large, as it can be.

    Attributes
    ----------
    minimize, maximize
        A response, or responses with weights: { shape_mse = 1.0, mass = 2.0 }. One of the two.
    over_cases
        Of several cases their "sum", or the "worst": a smooth maximum (KS), which is a little above the largest.
    aggregation
        How sharp the smooth maximum is, in 1/(unit of the objective): it is above the largest by at most log(cases)/aggregation.
    scale
        What a large change of it is, which says when a search ends. By default what the ranges of the variables change it by: the lower
        quartile, of all designs that the search has solved, of the largest derivative.
    robust
        How many standard deviations over the numbers of [uncertain] are added to the mean, or taken off where it is maximised: 2 minimises
        mean + 2 sigma. Every design is solved at some points of these numbers (uncertainty.points).
    """

    minimize: Weights = None
    maximize: Weights = None
    over_cases: Literal["sum", "worst"] = "sum"
    aggregation: Positive | None = None
    scale: Positive | None = None
    robust: Annotated[NotNegative | None, Quantity("none")] = None

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if (self.minimize is None) == (self.maximize is None):
            raise ValueError("an objective is one of `minimize` and `maximize`; write one of them, with a response or weights")
        if not self.weights or not all(self.weights.values()):
            raise ValueError("the objective needs responses with weights that are not zero; leave out what does not count")
        if (self.over_cases == "worst") != (self.aggregation is not None):
            raise ValueError('`aggregation`, in 1/(unit of the objective), belongs to over_cases = "worst"; write both or none')
        return self

    @classmethod
    def none(cls) -> Self:
        """The empty objective of a study that is not for an optimum."""
        return cls.model_construct(minimize={})

    @property
    def weights(self) -> Mapping[str, float]:
        """Weights of the objective's responses, response -> weight."""
        return (self.minimize if self.minimize is not None else self.maximize) or {}

    @property
    def sign(self) -> float:
        """Sign of the objective: 1 to minimize, -1 to maximize."""
        return 1.0 if self.minimize is not None else -1.0


class Study(Description):
    """A study of a scene: what of it may change, or is uncertain, and what is wanted.

    Attributes
    ----------
    scene
        The scene file, sought from the folder of the study file.
    analysis
        What is solved for every design: "statics", "motion", or "modes": statics with the frequencies of the vibrations about the
        equilibrium, which are built in as `frequency_1`, `frequency_2`, ... They are numbered where the scene stands, and recognised by the
        shapes of their modes at all other designs; a design at which none is alike fails.
    variables
        Path or short name of a number of the scene, or a new name of several numbers -> between which bounds it may be. Optima and sweeps
        need them.
    uncertain
        Path or short name of a number of the scene, or a new name of several numbers -> its distribution.
    objective
        What is to be as small or as large as possible; an optimum needs it.
    constraints
        Response -> its limits, in every case. `load_margin` is built in: the load factor of the first limit point.
    cases
        Name -> numbers of the scene that are others there, by path or short name. The same design is solved in all cases; without any, the
        scene itself is the only one.
    responses
        Responses beside those of the scene, written as there.
    search
        How the optimum is looked for.
    sweep
        Which designs a sweep solves.
    uncertainty
        How uncertain responses are found.
    directory
        Folder that the scene's path starts from; for a study file its own.
    """

    scene: FileName
    analysis: Literal["statics", "motion", "modes"] = "statics"
    variables: dict[str, StudyVariable] = Field(default_factory=dict)
    uncertain: dict[str, Uncertain] = Field(default_factory=dict)
    objective: Objective = Field(default_factory=Objective.none)
    constraints: dict[str, Limit] = Field(default_factory=dict)
    cases: dict[str, dict[str, Number]] = Field(default_factory=dict)
    responses: dict[str, Annotated[Registered, WithJsonSchema({"type": "object", "required": ["type"]})]] = Field(
        default_factory=dict
    )
    search: Search = Search()
    sweep: Sweep = Sweep()
    uncertainty: Uncertainty = Uncertainty()
    directory: Annotated[Path, WithJsonSchema({"type": "string"})] = Path()
