"""The errors that a user of the toolkit can meet, each with what, where, what would be right and the next step."""

from __future__ import annotations

import re
from collections.abc import Iterable
from copy import copy
from difflib import get_close_matches
from itertools import groupby
from reprlib import Repr
from typing import Any, TypeVar


class ToolkitError(Exception):
    """Base of every error that the toolkit raises on purpose; the command line prints its text without a traceback."""

    def __reduce__(self) -> tuple[object, ...]:
        """Form in which other processes get the error: with its text and attributes, whatever its constructor takes."""
        return error_again, (type(self), *self.args), dict(self.__dict__)


def error_again(kind: type[ToolkitError], *args: object) -> ToolkitError:
    """Error of a kind with its text.

    Python itself would call the constructor with the text alone, which some do not take.
    """
    return kind.__new__(kind, *args)


Told = TypeVar("Told", bound=ToolkitError)


def retold(error: Told, text: str) -> Told:
    """Copy of an error with another text; what else it carries stays."""
    found = copy(error)
    found.args = (text,)
    return found


def refusal(error: OSError) -> str:
    """Message on what the system refused, where nobody nearer to it knew what to say."""
    where = f" at {str(error.filename)!r}" if error.filename is not None else ""
    return f"the system refused to go on{where}: {error.strerror or error}. Fix the path, or make room on the disk."


def out_of_memory(error: MemoryError) -> str:
    """Message on what does not fit into memory, where nobody nearer to it counted it before."""
    what = str(error) or "the system gives no more"
    return f"the memory does not hold what this takes ({what}). Describe it by fewer numbers, or take a larger machine."


def without_content(reason: str) -> str:
    """Message of a library on a file that it cannot read, without what it quotes of the file, which may be anybody's."""
    return re.sub(r"""["'`].*["'`]""", "...", reason, flags=re.DOTALL)


class InputError(ToolkitError, ValueError):
    """The user's input is invalid: a scene, a path, a number, an option."""


class NoDerivativeError(InputError):
    """The motion has no derivative by some design variables, whose names are `variables`, because the joints do not allow it."""

    def __init__(self, message: str, variables: tuple[str, ...]) -> None:
        super().__init__(message)
        self.variables = variables


class NeedsDirectError(InputError):
    """The adjoint lacks derivatives of the states that direct differentiation has; `why` says which."""

    def __init__(self, why: str) -> None:
        super().__init__(f"{why}. Use the direct method.")
        self.why = why


class ModelFileError(ToolkitError, ValueError):
    """A reduced-model file is missing, damaged, foreign or of another schema version."""


class SingularSystemError(ToolkitError, ArithmeticError):
    """The equations have no unique solution: a free mechanism in statics, redundant or contradictory joints."""


class ConvergenceError(ToolkitError, ArithmeticError):
    """Newton's iteration stopped before it met its criterion; `state` is the time before a step that failed, with q and v then."""

    state: tuple[float, Any, Any] | None = None


class LimitPositionError(ConvergenceError):
    """Drivers lead a mechanism to a position behind which no position of its bodies closes the joints."""


class NoLimitPointError(ConvergenceError):
    """The path of equilibria was followed to the load factor `reached` and has no limit point there."""

    def __init__(self, message: str, reached: float) -> None:
        super().__init__(message)
        self.reached = reached


class CriticalPointError(ConvergenceError):
    """Statics met a point without stiffness: `load_factor` is the part of the load there, `coordinate` what moves most."""

    def __init__(self, message: str, load_factor: float, coordinate: str) -> None:
        super().__init__(message)
        self.load_factor = load_factor
        self.coordinate = coordinate


class LimitPointError(CriticalPointError):
    """The static path turns back (snap-through): there is no more load than this near by."""


class BifurcationError(CriticalPointError):
    """The static path goes on, but is unstable from there (buckling)."""


class CriticalStateError(ToolkitError, ArithmeticError):
    """Derivatives of an equilibrium at a limit point or bifurcation, where they are infinite."""


class ConformanceError(ToolkitError, ArithmeticError):
    """A component states a derivative that is not the derivative of its own law."""


SIMILAR_NAMES = 0.6
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
    close = get_close_matches(name, list(names), n=1, cutoff=SIMILAR_NAMES)
    return f", did you mean {close[0]!r}" if close else ""


def quoted(names: Iterable[str]) -> str:
    """Names in quotes with an "and" before the last."""
    *others, last = [repr(name) for name in names]
    return f"{', '.join(others)} and {last}" if others else last
