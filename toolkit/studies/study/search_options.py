"""How an optimum is looked for."""

from __future__ import annotations

from typing import Annotated, Any, Literal, get_args

from pydantic import BeforeValidator, Field, WithJsonSchema

from toolkit.description.description import Description
from toolkit.description.quantity import Quantity
from toolkit.description.run_options import Count

Part = Annotated[float, Field(strict=True, gt=1e-12, lt=1.0), Quantity("none")]


Method = Literal["slsqp", "trust-constr", "mma", "ccsa"]


def _several(value: Any) -> Any:
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
