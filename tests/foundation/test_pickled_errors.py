"""Errors reach other processes whole: every kind of error of the program, with its text and what it carries."""

from __future__ import annotations

import copy
import inspect
import pickle
import re
from importlib import import_module
from pathlib import Path

import pytest

from toolkit.foundation.errors import BifurcationError, ToolkitError, retold

ROOT = Path(__file__).parents[2]
DEFINED = re.compile(r"^class \w+\(.*Error\b", re.MULTILINE)
GIVEN = {"str": "a text\nof two lines", "float": 0.25, "int": 3, "tuple[str, ...]": ("t_w", "points.A.x")}
"""Annotation of a constructor's argument -> a value for it."""


def kinds() -> list[type[ToolkitError]]:
    """All kinds of errors that modules of the program define, found in their texts."""
    for path in sorted([*ROOT.glob("toolkit/**/*.py"), *ROOT.glob("preprocessing/**/*.py")]):
        if DEFINED.search(path.read_text(encoding="utf-8")):
            import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
    return sorted(below(ToolkitError), key=lambda kind: kind.__qualname__)


def below(kind: type[ToolkitError]) -> set[type[ToolkitError]]:
    """A kind of error and all kinds that derive from it."""
    return {kind}.union(*map(below, kind.__subclasses__()))


def example(kind: type[ToolkitError]) -> ToolkitError:
    """One error of a kind, by what its constructor takes."""
    if not inspect.isfunction(kind.__init__):
        return kind("a text")
    _, *wanted = inspect.signature(kind.__init__).parameters.values()
    return kind(*(GIVEN[inspect.formatannotation(each.annotation).strip("'")] for each in wanted))


def sent(error: ToolkitError) -> ToolkitError:
    """What another process gets."""
    return pickle.loads(pickle.dumps(error))  # noqa: S301 (it was made here)


@pytest.mark.parametrize("kind", kinds(), ids=lambda kind: kind.__name__)
@pytest.mark.parametrize("again", [sent, copy.copy])
def test_an_error_of_every_kind_is_the_same_elsewhere(kind, again):
    error = example(kind)
    error.add_note("a note")
    found = again(error)
    assert type(found) is kind
    assert (str(found), found.args, vars(found)) == (str(error), error.args, vars(error))


def test_an_error_told_anew_keeps_what_it_carries():
    found = retold(BifurcationError("it buckles", 0.5, "rise"), "at 3 rad/s: it buckles")
    assert (type(found), str(found), found.load_factor, found.coordinate) == (
        BifurcationError,
        "at 3 rad/s: it buckles",
        0.5,
        "rise",
    )


def test_the_errors_with_more_than_a_text_are_among_them():
    names = {kind.__name__ for kind in kinds()}
    assert {"LimitPointError", "BifurcationError", "NoLimitPointError", "NoDerivativeError", "NeedsDirectError"} <= names
