"""Verdict on the numbers of a run, with reasons: the same in Python, in JSON and on the terminal."""

from __future__ import annotations

import inspect
import math
import re
from bisect import insort
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import TYPE_CHECKING, Any, Generic, ParamSpec

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Record

PAGE = "docs/doubts.md"
"""The page with all codes of cautions."""
REGISTRY = Path(__file__).with_name("codes.toml")
"""File with the codes that studies and commands tell: one line for each."""
ROOM = "toolkit.validity"
"""Room whose modules hold the checks of scenes and runs; a new file there is enough."""
MOTION, REST, SPIN, SCENE = "motion", "equilibrium at rest", "steady spin", "scene"
"""What a check can apply to: a kind of solution, or what is written."""
STATES = (MOTION, REST, SPIN)
"""All kinds of solutions."""

P = ParamSpec("P")


@dataclass(frozen=True)
class Caution:
    """A reason to doubt the numbers of a run, or a remark on what they mean.

    Attributes
    ----------
    code
        Its short name, the same in every version, for example "energy"; docs/doubts.md has all of them.
    text
        What was found, with its numbers, and what to do next.
    doubt
        Whether the numbers are not to be trusted because of it; otherwise they are right, but may mean something else than one thinks.
    body
        The flexible body that a doubt about deflections is about, by which answers can weigh it; otherwise empty.
    part
        By which part these deflections are off.
    """

    code: str
    text: str
    doubt: bool = True
    body: str = field(default="", compare=False)
    part: float = field(default=math.inf, compare=False)


@dataclass(frozen=True, eq=False)
class Check(Generic[P]):
    """One kind of caution: what it means, from which size on it is said, what helps, and the function that measures it.

    Attributes
    ----------
    code
        Code of its cautions.
    means
        What was found where a caution has this code.
    limit
        From which size on it is said, and why.
    remedy
        What helps.
    applies_to
        Which of `STATES` are checked, or `SCENE`; empty of a check that others call.
    measure
        Function that yields cautions: of a solution, or of a scene. None of codes in `REGISTRY`.
    each_design
        Whether every design of a map is checked by itself: of what grows exponentially, designs nearby say nothing.
    by_result
        Whether a result checks it by its responses, so that it is not asked of the states beside them.
    """

    code: str
    means: str
    limit: str
    remedy: str
    applies_to: Sequence[str] = ()
    measure: Callable[P, Iterable[Caution]] | None = None
    each_design: bool = False
    by_result: bool = False

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> Iterable[Caution]:
        """Cautions that the check's function finds."""
        assert self.measure is not None
        return self.measure(*args, **kwargs)

    def caution(self, text: str, doubt: bool = True, body: str = "", part: float = math.inf) -> Caution:
        """A caution of this kind, see `Caution`."""
        return Caution(self.code, text, doubt, body, part)

    @property
    def fix(self) -> str:
        """Sentence with the remedy, for messages."""
        return f"Fix: {self.remedy[:1].lower()}{self.remedy[1:]}".replace("`", "")


_CHECKS: list[Check[Any]] = []


def _order(found: Check[Any]) -> tuple[int, str]:
    """Place among the checks, in which they are kept because every run goes through them."""
    return len(found.applies_to), str(found.measure.__module__)


def check(
    code: str, applies_to: Sequence[str] = (), each_design: bool = False, by_result: bool = False
) -> Callable[[Callable[P, Iterable[Caution]]], Check[P]]:
    """Make a check of a function that yields cautions, and register it.

    Its docstring begins with what was found. Paragraphs that begin with `Limit:` and `Fix:` say from which size on it is said, and what
    helps. They stand once for every code: a second function with the same code leaves them out.
    """

    def register(measure: Callable[P, Iterable[Caution]]) -> Check[P]:
        text = inspect.cleandoc(measure.__doc__ or "")
        said = dict(re.findall(r"^(Limit|Fix): (.*?)(?=\n\n|\nFix: |\Z)", text, re.MULTILINE | re.DOTALL))
        means, limit, fix = (
            " ".join(each.split()) for each in (text.partition("\n\n")[0], said.get("Limit", ""), said.get("Fix", ""))
        )
        remedy = f"{fix[:1].upper()}{fix[1:]}"
        found = Check(code, means, limit.removesuffix("."), remedy, applies_to, measure, each_design, by_result)
        insort(_CHECKS, found, key=_order)
        return found

    return register


@cache
def _discover() -> None:
    for found in walk_packages(import_module(ROOM).__path__, f"{ROOM}."):
        import_module(found.name)


def checks() -> list[Check[Any]]:
    """All checks of scenes and runs: those of one kind of solution before those of all, then in the order of their modules."""
    _discover()
    return _CHECKS


def codes() -> Mapping[str, Check[Any]]:
    """All codes that cautions can have in the order of the alphabet, and the meaning of each."""
    import tomllib

    told = {code: Check(code, **row) for code, row in tomllib.loads(REGISTRY.read_text(encoding="utf-8")).items()}
    told |= {each.code: each for each in checks() if each.limit}
    return dict(sorted(told.items()))


@dataclass(frozen=True)
class Verdict:
    """All cautions of a run, and what follows from them.

    Attributes
    ----------
    warnings
        What whoever reads the numbers has to know, doubts first.
    measures
        Name -> what was measured to find out, also where it speaks for the numbers: "drift", "energy_balance", "estimated_error".
    """

    warnings: tuple[Caution, ...] = ()
    measures: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, cautions: Iterable[Caution], measures: Mapping[str, object] | None = None) -> Verdict:
        """Verdict that follows from cautions: each is said once, doubts before remarks."""
        return cls(tuple(sorted(dict.fromkeys(cautions), key=lambda each: not each.doubt)), measures or {})

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Verdict:
        """Verdict that `record` was made of."""
        reasons = record["verdict"]["reasons"]
        cautions = [Caution(each["code"], each["text"], each["text"] in reasons) for each in record["warnings"]]
        return cls.of(cautions, {name: value for name, value in record.items() if name not in ("verdict", "warnings")})

    @property
    def trusted(self) -> bool:
        """Whether nothing speaks against the numbers."""
        return not self.reasons

    @property
    def reasons(self) -> tuple[str, ...]:
        """Reasons why the numbers are not to be trusted; empty if they are."""
        return tuple(each.text for each in self.warnings if each.doubt)

    def __str__(self) -> str:
        """Text with one sentence for the verdict, and one for each caution."""
        said = "Trusted: no check found a reason against these numbers." if self.trusted else "NOT TO BE TRUSTED, because:"
        return "\n".join([said, *(f"{'-' if each.doubt else 'note:'} {each.text}" for each in self.warnings)])

    @property
    def codes(self) -> tuple[str, ...]:
        """Short names of all cautions, each once.

        docs/doubts.md and `explained` say what they mean, from which size on, and what helps.
        """
        return tuple(dict.fromkeys(each.code for each in self.warnings))

    @property
    def explained(self) -> dict[str, Check[Any]]:
        """Code of each caution -> what it means, from which size on it is said, and what helps."""
        known = codes()
        return {code: known[code] for code in self.codes if code in known}

    def record(self) -> Record:
        """Keys of a JSON object: what was measured, `verdict` and `warnings`; a number that does not exist is None."""
        return {
            **finite(self.measures),
            "verdict": {"trusted": self.trusted, "reasons": list(self.reasons)},
            "warnings": [{"code": each.code, "text": each.text} for each in self.warnings],
        }


def finite(value: object) -> Any:
    """The same value, with None for numbers that JSON does not know."""
    if isinstance(value, Mapping):
        return {key: finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
