"""Base of responses that look at one point of a body."""

from __future__ import annotations

from toolkit.responses.instant import Instant


class OnePoint(Instant):
    """Base of responses that look at one point of a body.

    Attributes
    ----------
    body
        Name of the body.
    point
        Name of the point on it.
    """

    body: str
    point: str

    def markers(self) -> tuple[tuple[str, str], ...]:
        """The point on the body."""
        return ((self.body, self.point),)
