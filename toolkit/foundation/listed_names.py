"""Names listed in a message, however many there are."""

from __future__ import annotations

import re
from collections.abc import Iterable
from difflib import get_close_matches
from itertools import groupby
from reprlib import Repr

ALIKE = 0.6
"""Likeness of two names, by difflib's measure, from which one is taken for the other."""
NUMBERED = re.compile(r"(.*?)(\d+)$")
SHORT = Repr()
"""Form in which values are shown in a message."""
SHORT.maxstring = SHORT.maxother = 60


def listed(names: Iterable[str]) -> str:
    """Names for a message; of a numbered family, such as the thickness of every element, only the first and the last."""
    shown: list[str] = []
    for _, family in groupby(names, lambda name: found[1] if (found := NUMBERED.match(name)) else name):
        members = list(family)
        shown += members if len(members) < 4 else [f"{members[0]} ... {members[-1]}"]
    return ", ".join(shown) or "none"


def meant(name: str, names: Iterable[str]) -> str:
    """Part of a sentence with the probable meaning of a name that is none of these; empty if nothing is like it."""
    close = get_close_matches(name, list(names), n=1, cutoff=ALIKE)
    return f", did you mean {close[0]!r}" if close else ""


def quoted(names: Iterable[str]) -> str:
    """Names in quotes with an "and" before the last."""
    *others, last = [repr(name) for name in names]
    return f"{', '.join(others)} and {last}" if others else last
