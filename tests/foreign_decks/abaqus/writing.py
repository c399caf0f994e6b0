"""How a deck may be spelled: keyword lines, data lines and numbers that mean the same, chosen at random."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from random import Random

MARK = "\x01"
"""Stands at the end of lines that an error is to name; it is not written."""
REMARKS = ("**", "** *NODE", "** 1, 2, 3", "**Größe in mm", "   ** indented", '** a, b = "c', "***")
HEADINGS = ("a bar, made of 8 elements", "1, 2, 3", '"quoted, name=x', "50 % = half; node 7", "ELSET", "größer", ", ,")


@dataclass(eq=False)
class Chunk:
    """A keyword line with its data lines, as they are written."""

    head: list[str]
    data: list[str] = field(default_factory=list)
    names: list[tuple[str, str, str]] = field(default_factory=list)  # kind, label and spelling of the set that it adds to
    movable: bool = False  # whether its data lines may stand in a file of INPUT

    @property
    def lines(self) -> list[str]:
        """All lines."""
        return [*self.head, *self.data]


class Pen:
    """Writes chunks in a style of its own, plain or odd."""

    def __init__(self, rng: Random, odd: float, calculix: bool = False) -> None:
        self.rng, self.odd = rng, odd
        self.calculix = (
            calculix  # whether CalculiX 2.20 is to read it, which knows no lines of a keyword that go on, and no quotes
        )

    def maybe(self, share: float = 0.5) -> bool:
        """Whether something odd happens, so often at most."""
        return self.rng.random() < share * self.odd

    def head(self, keyword: str, *flags: str, **parameters: object) -> list[str]:
        """A keyword line, or several that continue one another; parameters are named with _ for blanks."""
        pieces = [f"{' ' * self.maybe(0.2)}*{' ' * self.maybe(0.05)}{self.word(keyword)}"]
        more = [(name.replace("_", " "), value) for name, value in parameters.items()] + [(flag, None) for flag in flags]
        if not self.calculix:  # which looks for the name of a set in the first parameter
            self.rng.shuffle(more)
        for name, value in more:
            equals = self.rng.choice(["=", " = ", "= "]) if self.maybe() else "="
            pieces.append(self.word(name) + ("" if value is None else f"{equals}{value}"))
        lines = [pieces[0]]
        for piece in pieces[1:]:
            if not self.calculix and self.maybe(0.2):
                lines[-1] += "," + " " * self.maybe()
                if self.maybe(0.3):
                    lines.append("** between the lines of a keyword")
                lines.append(piece)
            else:
                lines[-1] += self.rng.choice([",", ", ", " , "] if self.odd else [", "]) + piece
        lines[-1] += " " * self.maybe(0.2)
        return lines

    def chunk(self, keyword: str, rows: Sequence[Sequence[str]] = (), *flags: str, **parameters: object) -> Chunk:
        """A keyword line with data lines."""
        return Chunk(self.head(keyword, *flags, **parameters), self.rows(rows))

    def rows(self, rows: Sequence[Sequence[str]]) -> list[str]:
        """Data lines, with comments and blank lines between them."""
        found = []
        for row in rows:
            if self.maybe(0.15):
                found.append(self.rng.choice(REMARKS))
            if self.maybe(0.05):
                found.append(" " * self.rng.randint(0, 2))
            found.append(self.line(row))
        return found + [self.rng.choice(REMARKS)] * self.maybe(0.2)

    def line(self, row: Sequence[str]) -> str:
        """One data line."""
        comma = self.rng.choice([",", ", ", " , ", ",\t"]) if self.maybe(0.4) else ", "
        text = comma.join(row)
        text += "," * ((self.maybe(0.15) or (len(row) == 1 and self.rng.random() < 0.3)) and not text.endswith(","))
        return " " * (self.rng.randint(0, 3) if self.maybe(0.3) else 0) + text + " " * self.maybe(0.1)

    def word(self, text: str) -> str:
        """A keyword or parameter in one of its spellings."""
        if self.maybe(0.3):
            text = text.replace(" ", "")
        return self.rng.choice([text, text.lower(), text.title()])

    def label(self, name: str) -> str:
        """A name of a set, part or instance; case does not count unless it is quoted."""
        return name if name.startswith('"') or not self.maybe(0.6) else self.rng.choice([name.upper(), name.lower()])

    def number(self, value: float) -> str:
        """A number, whose decimal digits are kept whatever its form."""
        text = repr(float(value))
        if not self.odd or self.rng.random() < 0.6:
            return text
        mantissa, _, exponent = text.partition("e")
        shift = self.rng.choice([-2, -1, 0, 1, 3])
        moved = format(Decimal(mantissa).scaleb(-shift), "f")
        letter = self.rng.choice("eEdD")
        power = int(exponent or 0) + shift
        found = moved + (
            f"{letter}{self.rng.choice(['', '+']) if power >= 0 else ''}{power}" if power or self.rng.random() < 0.3 else ""
        )
        if self.rng.random() < 0.5:
            found = re.sub(r"^(-?)0\.(?=[0-9])", r"\1.", found)
        elif self.rng.random() < 0.5:
            found = re.sub(r"\.0+(?=$|[eEdD])", ".", found)
        return found if value < 0 or found.startswith("-") or self.rng.random() < 0.9 else f"+{found}"

    def numbers(self, values: Sequence[float]) -> list[str]:
        """Numbers of a line; zeros may be left empty, and missing at its end."""
        found = [("" if value == 0 and self.maybe(0.4) else self.number(value)) for value in values]
        while found and not found[-1] and self.maybe(0.5):
            found.pop()
        return found

    def broken(self, row: Sequence[str], longest: int = 16) -> list[str]:
        """One element over one line or several, each of which may end with a comma; at most so many numbers a line."""
        lines, rest = [], list(row)
        while rest:
            odd = self.maybe(0.3)
            many = self.rng.randint(1, min(len(rest), longest)) if odd else min(len(rest), longest)
            lines.append(", ".join(rest[:many]))
            rest = rest[many:]
        return [line + "," * (k + 1 < len(lines) and not self.maybe(0.3)) for k, line in enumerate(lines)]


def as_file(rng: Random, lines: Sequence[str], odd: bool) -> tuple[bytes, list[int]]:
    """The bytes of a file, and numbers of the lines that are marked."""
    marked = [k for k, line in enumerate(lines, start=1) if MARK in line]
    ending = rng.choice(["\n", "\r\n", "\r"]) if odd else "\n"
    text = ending.join(lines).replace(MARK, "") + (ending if rng.random() < 0.9 or not lines else "")
    encoding = rng.choice(["utf-8", "utf-8-sig", "latin-1"]) if odd else "utf-8"
    return text.encode(encoding, "replace"), marked
