"""Which designs a sweep solves."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from toolkit.description.description import Description, FileName
from toolkit.description.run_options import Count, Seed

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
