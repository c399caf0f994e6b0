"""Design variables: short names for the paths of numbers in a scene, in the order of the columns of every derivative."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class DesignVariable:
    """One number of the scene: its short name and the path that leads to it, for example `points.A.x`."""

    name: str
    path: str
    value: float


@dataclass(frozen=True)
class Design:
    """The design variables of a scene; their order is the order of the last axis of all derivatives."""

    variables: tuple[DesignVariable, ...]

    def __len__(self) -> int:
        return len(self.variables)

    def __iter__(self) -> Iterator[DesignVariable]:
        return iter(self.variables)

    @property
    def names(self) -> tuple[str, ...]:
        """Short names, in column order."""
        return tuple(variable.name for variable in self.variables)

    @property
    def values(self) -> Mapping[str, float]:
        """Short name to value."""
        return {variable.name: variable.value for variable in self.variables}
