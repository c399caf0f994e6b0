"""Base of responses that look at one point of a body."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from toolkit.responses.instant import Instant


class OnePoint(Instant):
    """Base of responses that refer to one point of a body.

    Attributes
    ----------
    body
        Name of the body.
    point
        Name of the point on it.
    """

    body: str
    point: str

    @model_validator(mode="after")
    def _of_a_body(self) -> Self:
        if self.body == "ground":
            raise ValueError(f"the ground does not move, so that it has no {self.kind}; name a body that moves")
        return self

    def markers(self) -> tuple[tuple[str, str], ...]:
        """Pair of body and point."""
        return ((self.body, self.point),)
