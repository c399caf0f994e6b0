"""What a study compares."""

from __future__ import annotations

from typing import NamedTuple


class Studied(NamedTuple):
    """A response, or its gradient."""

    response: str
    derived: bool

    def __str__(self) -> str:
        return f"d({self.response})" if self.derived else self.response
