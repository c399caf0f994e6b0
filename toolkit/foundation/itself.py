"""Keys of what is remembered of things that are not compared: too large, or never equal by what is in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Itself(Generic[T]):
    """Key that equals itself alone, whatever is in it."""

    item: T

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Itself) and self.item is other.item

    def __hash__(self) -> int:
        return id(self.item)
