"""Records of a system as compiled code takes them, each made once; and scratch memory, which one run takes over from another.

To reserve memory and to tell compiled code where it is takes as long as some steps of a small mechanism.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import Any, TypeVar

from toolkit.foundation.compiled.calls import in_memory

R = TypeVar("R")


class HandedRecords:
    """Parts of a system, which never change, as compiled code takes them, and scratch memory that is not in use.

    Parameters
    ----------
    parts
        Of the system; whatever is no tuple is handed on as it is.
    """

    def __init__(self, parts: Iterable[Any]) -> None:
        self._packed: dict[int, Any] = {id(part): None for part in parts if isinstance(part, tuple)}
        self._spare: dict[Hashable, list[Any]] = {}

    def take(self, part: Any) -> None:
        """Know another record, which has to live as long as the system."""
        self._packed[id(part)] = None

    def of(self, given: Any) -> Any:
        """Argument in the form that compiled code takes, if it is known here; else the argument itself."""
        known = id(given)
        if known not in self._packed:
            return given
        if self._packed[known] is None:
            self._packed[known] = in_memory(given)
        return self._packed[known]

    def scratch(self, key: Hashable, make: Callable[[], R]) -> R:
        """A record of scratch memory, whatever it holds: one that was given back under the key, or else a new one."""
        try:
            packed = self._spare[key].pop()
        except (KeyError, IndexError):
            packed = in_memory(make())
        self._packed[id(packed.record)] = packed
        found: R = packed.record
        return found

    def give_back(self, key: Hashable, record: Any) -> None:
        """Keep a record of `scratch` for the next one that asks."""
        self._spare.setdefault(key, []).append(self._packed.pop(id(record)))

    def share_spare(self, other: HandedRecords) -> None:
        """Have the scratch memory of another system, whose arrays have the same shapes."""
        self._spare = other._spare

    def shares_spare(self, other: HandedRecords) -> bool:
        """Whether it has the scratch memory of another system."""
        return self._spare is other._spare
