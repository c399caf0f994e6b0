"""Verdict on the numbers of a run, with reasons: the same in Python, in JSON and on the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

PAGE = "docs/doubts.md"
"""The page with all codes of cautions."""
REGISTRY = Path(__file__).with_name("codes.toml")
"""File that the page is made from: one line for each code."""


@dataclass(frozen=True)
class Code:
    """Meaning of one code of cautions.

    Attributes
    ----------
    means
        What was found where a caution has this code.
    limit
        From which size on it is said.
    remedy
        What helps.
    """

    means: str
    limit: str
    remedy: str


@cache
def codes() -> Mapping[str, Code]:
    """All codes that cautions can have, and the meaning of each."""
    import tomllib

    return {code: Code(**row) for code, row in tomllib.loads(REGISTRY.read_text(encoding="utf-8")).items()}


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
    def of(cls, cautions: Iterable[Caution], measures: Mapping[str, Any] | None = None) -> Verdict:
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
    def explained(self) -> dict[str, Code]:
        """Code of each caution -> what it means, from which size on it is said, and what helps."""
        return {code: codes()[code] for code in self.codes if code in codes()}

    def record(self) -> dict[str, Any]:
        """Keys of a JSON object: what was measured, `verdict` and `warnings`; a number that does not exist is None."""
        return {
            **finite(self.measures),
            "verdict": {"trusted": self.trusted, "reasons": list(self.reasons)},
            "warnings": [{"code": each.code, "text": each.text} for each in self.warnings],
        }


def finite(value: Any) -> Any:
    """The same value, with None for numbers that JSON does not know."""
    if isinstance(value, Mapping):
        return {key: finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
