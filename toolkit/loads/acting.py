"""Loads that have no effect unless some number of theirs is written."""

from __future__ import annotations

from typing import ClassVar, Self

from pydantic import model_validator

from toolkit.description.description import Description
from toolkit.loads.places import name_of


class Acting(Description):
    """Base of loads of which one number at least is to be written. It may be zero: what begins there can be varied."""

    acts_by: ClassVar[tuple[str, ...]] = ("stiffness", "damping")
    """Names of these numbers."""

    @model_validator(mode="after")
    def _acts(self) -> Self:
        if not self.model_fields_set.intersection(self.acts_by):
            *others, last = self.acts_by
            names = f"{', '.join(others)} or {last}"
            raise ValueError(f"{name_of(self)} has no effect without {names}; give one of them")
        return self
