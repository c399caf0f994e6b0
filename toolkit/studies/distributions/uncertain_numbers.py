"""Numbers that are not known exactly, and what is asked about what follows from them."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from toolkit.description.description import Description, Number, Pair, Positive
from toolkit.description.design import check_shares
from toolkit.description.quantity import Quantity
from toolkit.description.run_options import Count, Seed

Coefficient = Annotated[float, Field(strict=True, gt=-1, lt=1), Quantity("none")]
Share = Annotated[float, Field(strict=True, gt=0, lt=1), Quantity("none")]


class Uncertain(Description):
    """The distribution of a number of the scene, or of several that one variable moves.

    Attributes
    ----------
    distribution
        "normal", "lognormal" or "uniform".
    mean
        Of a normal or lognormal number; by default what the scene has.
    sigma
        Standard deviation of a normal or lognormal number, in its own unit.
    between
        Least and largest value. A uniform number needs them; they cut off a normal or lognormal one, whose mean and sigma are those before.
    of
        Paths of numbers of one unit that move together: the distribution is that of by how much, 0 where the scene stands. Without it the
        number is the one that its own name leads to, a path or a short name of the scene.
    factors
        Of each of these numbers: by how much it moves where the variable moves by one. All are one by default.
    """

    distribution: Literal["normal", "lognormal", "uniform"]
    mean: Number | None = None
    sigma: Positive | None = None
    between: Pair | None = None
    of: tuple[str, ...] | None = Field(default=None, min_length=1)
    factors: tuple[Number, ...] | None = None

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if self.between is not None and self.between[0] >= self.between[1]:
            low, high = self.between
            raise ValueError(
                f"between = [{low:g}, {high:g}] holds nothing; write the smaller bound first, and the larger one second"
            )
        if self.distribution == "uniform" and (self.between is None or self.mean is not None or self.sigma is not None):
            raise ValueError(
                "a uniform number is given by `between` alone: its least and largest value; leave out mean and sigma"
            )
        if self.distribution != "uniform" and self.sigma is None:
            raise ValueError(
                f"a {self.distribution} number needs `sigma`, its standard deviation; its mean is the scene's if it is left out"
            )
        check_shares(self.of, self.factors)
        return self


class Correlation(Description):
    """How two uncertain numbers go together.

    Attributes
    ----------
    of
        Their names.
    coefficient
        Pearson's coefficient of correlation of the numbers themselves, above -1 and below 1.
    """

    of: tuple[str, str]
    coefficient: Coefficient

    @model_validator(mode="after")
    def _fit(self) -> Self:
        if self.of[0] == self.of[1]:
            raise ValueError(f"{self.of[0]!r} goes together with itself anyway; name two numbers")
        return self


class Uncertainty(Description):
    """How `ffrf uncertainty` finds out what follows from uncertain numbers.

    Attributes
    ----------
    runs
        Designs that are solved with gradients; the first is the one of all means.
    degree
        Of the polynomials that values and gradients are fitted by; by default the one whose leave-one-out error is least.
    correlations
        Of pairs of uncertain numbers; all others are independent.
    quantiles
        Shares of all cases below the values that are asked for.
    responses
        Which are wanted; by default all that the analysis has, and the load margin if a constraint or the objective asks for it.
    monte_carlo
        Random designs that are solved without gradients, to judge the polynomials by; 0 for none.
    warm_starts
        Whether statics of all designs begins in the equilibrium of the first, which is several times faster, but can lead beyond a
        snap-through.
    seed
        Another one gives other designs.
    points
        Of a robust objective or limit: at how many points of the uncertain numbers every design is solved; the first is the one of all
        means. By default half as many again as a polynomial of degree 2 has coefficients; more points take a higher degree.
    """

    runs: Annotated[int, Field(strict=True, ge=2, le=1_000_000)] = 20
    degree: Count | None = None
    correlations: tuple[Correlation, ...] = ()
    quantiles: tuple[Share, ...] = (0.01, 0.05, 0.5, 0.95, 0.99)
    responses: tuple[str, ...] | None = Field(default=None, min_length=1)
    monte_carlo: Annotated[int, Field(strict=True, ge=0, le=1_000_000)] = 0
    warm_starts: bool = False
    seed: Seed = 0
    points: Annotated[int | None, Field(strict=True, ge=3, le=10_000)] = None
