"""Which parameter every element takes each quantity of its section from: the body's, its group's, or one of its own."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from preprocessing.elements.section import QUANTITIES, Patch
from toolkit.foundation.errors import InputError


class Group(Protocol):
    """Elements that share quantities apart from the body's."""

    @property
    def elements(self) -> Sequence[int]:
        """Numbers of the first and the last element of the group."""

    @property
    def values(self) -> Mapping[str, float]:
        """Quantities that the group has of its own, with their values."""


@dataclass(frozen=True)
class Parameters:
    """Patches of elements, and the parameters that they take their quantities from."""

    patches: list[Patch]
    values: dict[str, float] = field(default_factory=dict)  # parameter -> value
    quantities: dict[str, str] = field(default_factory=dict)  # parameter -> what it is, for its unit


def distribute(body: Mapping[str, float], groups: Mapping[str, Group], separate: Collection[str], n_elements: int) -> Parameters:
    """Give every element its parameters.

    An element has `thickness_<number>` if thickness is among the quantities `separate`, else `thickness_<group>` if its group has a
    thickness, else `thickness`. A parameter that no element takes does not exist.

    Raises
    ------
    InputError
        A group holds elements that do not exist or belong to another group.
    """
    owner = _owners(groups, n_elements)
    found = Parameters([])
    members: dict[tuple[tuple[str, str], ...], list[int]] = {}
    for element in range(n_elements):
        own_values = groups[owner[element]].values if owner[element] else {}
        names = {}
        for quantity, meaning in QUANTITIES.items():
            own = str(element) if quantity in separate else owner[element] if quantity in own_values else ""
            names[quantity] = f"{quantity}_{own}" if own else quantity
            found.values[names[quantity]] = own_values.get(quantity, body[quantity])
            found.quantities[names[quantity]] = meaning
        members.setdefault(tuple(names.items()), []).append(element)
    found.patches.extend(Patch(np.array(elements), dict(names)) for names, elements in members.items())
    return Parameters(found.patches, _in_order(found.values), _in_order(found.quantities))


def _owners(groups: Mapping[str, Group], n_elements: int) -> list[str]:
    owner = [""] * n_elements
    for name, group in groups.items():
        first, last = group.elements
        if not 0 <= first <= last < n_elements:
            raise InputError(
                f"{name}: elements from {first} to {last} are not on the skin, whose elements count from 0 to "
                f"{n_elements - 1}. Give the first and the last one in this order."
            )
        for element in range(first, last + 1):
            if owner[element]:
                raise InputError(f"{name}: element {element} belongs to group {owner[element]!r} too. Let each have one group.")
            owner[element] = name
    return owner


def _in_order(named: dict) -> dict:
    """Quantity by quantity, and in each by the first element that takes the parameter."""
    return {name: named[name] for quantity in QUANTITIES for name in named if _quantity(name) == quantity}


def _quantity(parameter: str) -> str:
    return next(quantity for quantity in QUANTITIES if parameter == quantity or parameter.startswith(f"{quantity}_"))
