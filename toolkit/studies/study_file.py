"""The file of a study: a scene, its variables or uncertain numbers, what is wanted of it, and how an optimum is looked for."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BeforeValidator, Field, ValidationError, WithJsonSchema, model_validator

from toolkit.description.description import Description, FileName, NotNegative, Number, Pair, Positive, Quantity, Registered
from toolkit.description.design import check_shares
from toolkit.description.run_options import Count, Seed
from toolkit.description.validation_messages import messages
from toolkit.files.scene_reader import responses_from_table
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.toml_file import naming_lines, read_toml, refuse_other
from toolkit.foundation.value_types import TomlTable
from toolkit.studies.distributions import Uncertain, Uncertainty

Part = Annotated[float, Field(strict=True, gt=1e-12, lt=1.0), Quantity("none")]


Method = Literal["slsqp", "trust-constr", "mma", "ccsa"]


def _several(value: object) -> Any:
    """A method alone is the only one."""
    return (value,) if isinstance(value, str) else value


_ONE = {"enum": list(get_args(Method)), "type": "string"}
Methods = Annotated[
    tuple[Method, ...],
    Field(min_length=1),
    BeforeValidator(_several),
    WithJsonSchema({"anyOf": [_ONE, {"type": "array", "items": _ONE, "minItems": 1}]}),
]


class Search(Description):
    """How an optimum is looked for, and when it is found.

    Attributes
    ----------
    method
        "slsqp", sequential quadratic programming, SciPy's, for some tens of variables. "mma", the method of moving asymptotes, and "ccsa",
        its sibling with quadratic approximations, NLopt's (extra `nlopt`): for hundreds of variables, where the others' matrices cost more
        than designs. "trust-constr", SciPy's interior-point method with a trust region, which takes smaller steps. Where the objective is a
        mean of squares (shape-mse, time-mean-square; robust ones too), first derivatives tell its curvature, and up to 50 variables all of
        them use it: they begin anew in variables in which that is round. Elsewhere SLSQP learns it from the designs that were solved;
        MMA and CCSA never do, and crawl along narrow valleys. Several in a list take turns, ["mma", "slsqp"]: each but the last solves a
        fifth of the evaluations, and the next one goes on from the best design.
    starts
        How many searches: the first begins where the scene stands, others at the points of Sobol's sequence within the bounds.
    evaluations
        Most designs that one search may solve.
    optimality
        The search ends where the KKT residual is below this part of the objective's scale, or of its largest derivative there: so much
        would be gained, at most, over the whole range of a variable. Where the objective tells its curvature, this promises less than the
        same part of the objective too.
    feasibility
        By how much of its scale a constraint may be violated.
    warm_starts
        Whether statics begins in the equilibrium of the nearest design that was solved before, which halves its time, but can lead a search
        to equilibria beyond a snap-through. An optimum is always solved again along the path from the unloaded state; if it is not found
        there, the search is repeated without warm starts.
    failures
        What to do where a design cannot be solved: "step-back", search on from the last design, on this side of a plane that cuts off
        the failed one;
        or "stop", end the search there.
    most_failures
        Failed designs after which a search ends.
    gradients
        How a motion is differentiated: "direct", or "adjoint" for many variables.
    certify
        Whether gradients at the optimum are compared with a complex step and differences.
    """

    method: Methods = ("slsqp",)
    starts: Count = 1
    evaluations: Count = 100
    optimality: Part = 1e-3
    feasibility: Part = 1e-6
    warm_starts: bool = False
    failures: Literal["step-back", "stop"] = "step-back"
    most_failures: Count = 20
    gradients: Literal["direct", "adjoint"] = "direct"
    certify: bool = True


Levels = Annotated[int, Field(strict=True, ge=1)]


class Sweep(Description):
    """Which designs `ffrf sweep` solves, and what it asks of them.

    Attributes
    ----------
    points
        "grid", every combination of equally spaced values; "latin-hypercube", scattered so that every variable takes as many values as
        there are designs; or "sobol", points of Sobol's sequence, scrambled: more of them leave the first ones as they are.
    levels
        Of a grid: how many values of every variable, or a table of variables; 5 by default. A variable with one level stays in the middle.
    count
        Of the others: how many designs; 64 by default.
    seed
        Another one gives other points of the others.
    file
        A CSV file with a column for every variable and a row for every design instead, sought from the folder of the study file.
    responses
        Which are wanted; by default all that the analysis has, and the load margin if a constraint or the objective asks for it.
    gradients
        Whether they are wanted too.
    """

    points: Literal["grid", "latin-hypercube", "sobol"] | None = None
    levels: Levels | dict[str, Levels] | None = None
    count: Count | None = None
    seed: Seed | None = None
    file: FileName | None = None
    responses: tuple[str, ...] | None = Field(default=None, min_length=1)
    gradients: bool = True

    @property
    def kind(self) -> str:
        """Where the designs come from."""
        return "file" if self.file is not None else self.points or "grid"

    @model_validator(mode="after")
    def _fit(self) -> Self:
        given = {"points": self.points, "levels": self.levels, "count": self.count, "seed": self.seed}
        if self.file is not None and (told := [name for name, value in given.items() if value is not None]):
            raise ValueError(f"the designs of a file need no {', '.join(told)}; leave out these, or `file`")
        if self.kind == "grid" and (self.count is not None or self.seed is not None):
            raise ValueError('a grid has `levels`, no `count` or `seed`; write points = "sobol" or "latin-hypercube" for these')
        if self.kind in ("latin-hypercube", "sobol") and self.levels is not None:
            raise ValueError(f'points = "{self.kind}" has a `count`, no `levels`; these belong to a grid')
        return self


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


def _weighted(value: object) -> Any:
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


TABLES = frozenset(Study.model_fields) - {"scene", "directory"}
"""First keys of a study file; errors that begin with another one are of the scene."""


def naming_study_lines(study: Study | str | Path) -> AbstractContextManager[None]:
    """Errors about keys of a study file say in which line they stand; a study made in Python has no lines."""
    return nullcontext() if isinstance(study, Study) else naming_lines(Path(study), TABLES)


def read_study(path: str | Path) -> Study:
    """Read a study file.

    Parameters
    ----------
    path
        The file, in TOML.

    Returns
    -------
    study
        The study, checked as far as it can be without its scene.

    Raises
    ------
    InputError
        The file is missing, is no TOML, or a key or value is wrong; all wrong keys are reported at once.
    """
    path = Path(path)
    table = read_toml(path, "a study in TOML")
    refuse_other(table, path, "study")
    with naming_lines(path):
        return _study(table, path)


def _study(table: TomlTable, path: Path) -> Study:
    problems: list[str] = []
    responses = responses_from_table(table.get("responses", {}), problems)
    if not problems:
        given = {**table, "responses": responses, "directory": path.parent}
        try:
            return Study.model_validate(given)
        except ValidationError as error:
            problems += messages(error, Study, given, "", {})
    raise InputError("\n".join(f"{path.name}: {problem}" for problem in problems))
