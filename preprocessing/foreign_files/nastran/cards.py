"""Cards of bulk data: a name and its fields, in small (8 columns), large (16 columns, marked by a star) or free format (commas).

A line whose first field is blank, or begins with + or *, continues a card: the one before it, or that with its mark in the tenth field.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

import numpy as np

from preprocessing.foreign_files.nastran.lines import BulkLines, FieldNumbers, real_numbers, whole_numbers
from toolkit.foundation.errors import InputError

FIXED_COLUMNS = 80
"""Columns of a line of fixed format; Nastran does not read beyond."""
NO_MARK = (b"", b"+", b"+".ljust(8), b" " * 8)
"""First or tenth fields without a mark."""
LONGEST_FIELD = 32
"""Characters of a field of free format; a number has 16 at most where the columns are fixed."""
NAME = re.compile(rb"[A-Z][A-Z0-9_]{0,7}")
COMMENTS = (b"//", b"#")
"""Beginnings of comment lines of OptiStruct, besides the dollar sign."""


class Card:
    """Card with its fields behind the name: eight characters each in `body`, or of any length in `fields`."""

    __slots__ = ("body", "excess", "fields", "line")

    def __init__(self, line: int) -> None:
        self.line = line
        self.body = b""
        self.fields: list[bytes] | None = None
        self.excess = False  # whether one of its lines has more than ten fields

    def append(self, data: bytes | list[bytes]) -> None:
        """Add the fields of another line."""
        if self.fields is None and isinstance(data, bytes):
            self.body += data
            return
        fields = self.fields if self.fields is not None else _split(self.body)
        if isinstance(data, bytes) or len(data) == 8:  # behind half of a pair of lines in large format
            fields.extend([b""] * (-len(fields) % 8))
        fields.extend(_split(data) if isinstance(data, bytes) else data)
        self.fields = fields

    def words(self) -> list[str]:
        """All fields as text in capitals."""
        fields = self.fields if self.fields is not None else _split(self.body)
        return [each.decode("ascii", "replace").upper() for each in fields]


def _split(body: bytes) -> list[bytes]:
    return [body[k : k + 8].strip() for k in range(0, len(body), 8)]


class Cards:
    """All cards, by name, and notes about the lines."""

    def __init__(self, lines: BulkLines) -> None:
        self.lines = lines
        self.by_name: dict[str, list[Card]] = {}
        self.long_lines = 0  # lines with something beyond the last column
        self.end: int | None = None  # line of ENDDATA
        self.after_end = False  # whether something follows it
        self._last: Card | None = None
        self._plain: dict[bytes, list[Card]] = {}  # first field of lines in small format -> cards of that name
        self._mark = b""  # in the tenth field of the line before
        self._waiting: dict[bytes, Card | None] = {}  # mark -> the card that goes on there; none if there are several
        self._early: dict[bytes, tuple[int, bytes | list[bytes], bytes]] = {}  # mark -> line that comes ahead of its card

    @classmethod
    def of(cls, lines: BulkLines, which: Iterable[int]) -> Cards:
        """Cards from some of the lines.

        Raises
        ------
        InputError
            A line begins with no name of a card, or continues none.
        """
        found = cls(lines)
        for k in which:
            line = lines.texts[k]
            if found._take_plain(k, line):
                continue
            if b"$" in line:
                line = line[: line.index(b"$")]
            if line.strip() and not line.startswith(COMMENTS):
                found._take(k, line.expandtabs(8) if b"\t" in line else line)
                if found.end is not None:
                    break
        found._resolve()
        found.after_end = found.end is not None and any(line.partition(b"$")[0].strip() for line in lines.texts[found.end + 1 :])
        lines.texts.clear()  # places of lines need no text
        return found

    def _take_plain(self, k: int, line: bytes) -> bool:
        """Take a line as most are: in small format, of a name that was there before, or with the mark of the line before it."""
        if b"$" in line or b"," in line or b"\t" in line or len(line) > FIXED_COLUMNS:
            return False
        head = line[:8]
        same = self._plain.get(head)
        if same is not None:
            card = Card(k)
            same.append(card)
            self._new(card)
        elif self._last is None or self._last.fields is not None or head[:1] != b"+" or head not in (*NO_MARK, self._mark):
            return False
        else:
            card = self._last
        card.body += line[8:72].ljust(64)
        self._mark = line[72:80]
        return True

    def _take(self, k: int, line: bytes) -> None:
        """Take one line, which is no comment and not blank."""
        excess = False
        data: bytes | list[bytes]
        if b"," in line:
            head, data, mark, excess = _free(line)
        else:
            head, mark = line[:8].strip(), line[72:80]
            large = b"*" in head
            data = [line[j : j + 16].strip() for j in (8, 24, 40, 56)] if large else line[8:72].ljust(64)
            self.long_lines += len(line) > FIXED_COLUMNS and bool(line[FIXED_COLUMNS:].strip())
        if not head or head[:1] in b"+*":
            card = self._continue(k, _key(head), data, mark)
        else:
            card = self._start(k, head.upper().rstrip(b"*").rstrip(), data, mark)
        if excess and card is not None:
            card.excess = True

    def _start(self, k: int, name: bytes, data: bytes | list[bytes], mark: bytes) -> Card | None:
        if name == b"ENDDATA":
            self.end = k
            return None
        if not NAME.fullmatch(name):
            what = (
                "a field is to be copied from the card before it"
                if name[:1] == b"="
                else "the line begins with no name of a card"
            )
            raise self.lines.error(k, f"{what}, which is not read. Write every card out, in bulk data.")
        card = Card(k)
        card.append(data)
        same = self.by_name.setdefault(name.decode(), [])
        same.append(card)
        self._plain.setdefault(name.ljust(8), same)
        self._new(card)
        self._mark = mark
        return card

    def _continue(self, k: int, key: bytes, data: bytes | list[bytes], mark: bytes) -> Card | None:
        """Append a line to the card before it, or to the one that waits for its mark; none if that one is still to come."""
        card = self._last
        if key and key not in _keys(self._mark):
            if key in self._waiting:
                card = self._waiting.pop(key)
                if card is None:
                    raise self.lines.error(k, "several cards go on with this mark. Give each of them a mark of its own.")
            elif _key(self._mark):
                if key in self._early:
                    raise self.lines.error(
                        k, "two lines with this mark continue no card before them. Write them behind their cards."
                    )
                self._early[key] = (k, data, mark)
                return None
        if card is None:
            raise self.lines.error(k, "the line continues a card, and there is none before it. Write it behind its card.")
        if card is not self._last:
            self._new(card)
        card.append(data)
        self._mark = mark
        return card

    def _new(self, card: Card) -> None:
        """Go on with another card; the one before may still go on where its mark is."""
        if self._mark not in NO_MARK and self._last is not None:
            for key in _keys(self._mark):
                self._waiting[key] = None if self._waiting.get(key, self._last) is not self._last else self._last
        self._last = card

    def _resolve(self) -> None:
        """Append the lines that came ahead of their cards."""
        self._new(Card(0))
        while self._early:
            key = next((key for key in self._early if self._waiting.get(key) is not None), None)
            if key is None:
                line = next(iter(self._early.values()))[0]
                raise self.lines.error(
                    line, "the line continues a card, and none has its mark in field 10. Write it behind its card."
                )
            _, data, mark = self._early.pop(key)
            card = self._waiting.pop(key)
            assert card is not None
            card.append(data)
            self._last, self._mark = card, mark
            self._new(card)


def _free(line: bytes) -> tuple[bytes, list[bytes], bytes, bool]:
    """First field, the eight or four fields behind it, mark, and whether there are more fields than a line has."""
    head, *fields = (each.strip() for each in line.split(b","))
    n = 4 if b"*" in head else 8
    data, mark = fields[:n], b"".join(fields[n : n + 1])
    more = any(fields[n + 1 :]) or mark[:1].isdigit() or b" " in head
    return (head.split() or [b""])[0], data + [b""] * (n - len(data)), mark, more


def _key(mark: bytes) -> bytes:
    """Continuation mark without the plus or star at its front."""
    return mark.strip().lstrip(b"+*").strip().upper()


def _keys(mark: bytes) -> set[bytes]:
    """Ways in which the next line may repeat a continuation mark: whatever stands in column 73 need not be part of it."""
    return {_key(mark), mark[1:].strip().upper()} - {b""}


class CardTable:
    """All cards of one name with as many fields each."""

    def __init__(self, name: str, cards: list[Card], fields: int, lines: BulkLines, rest: bool = False) -> None:
        """Read these many fields of every card; behind them is nothing, or what does not count (`rest`).

        Raises
        ------
        InputError
            A card has more fields, or one that is too long.
        """
        self.name, self.cards, self.lines = name, cards, lines
        for card in cards:
            more = card.body[8 * fields :].strip() if card.fields is None else any(card.fields[fields:])
            if card.excess or (more and not rest):
                raise lines.error(card.line, f"{name} has more fields than {fields}, or a line more than ten. Mend the card.")
        longest = max((len(card.body) // 8 if card.fields is None else len(card.fields) for card in cards), default=0)
        self._fields = fields
        self._text = self._padded(min(longest, fields))

    def __len__(self) -> int:
        return len(self.cards)

    def _padded(self, fields: int) -> np.ndarray:
        """Text of the first fields of every card, (n, fields, characters)."""
        text = np.full((len(self.cards), fields, 8), ord(" "), np.uint8)
        small = np.array([card.fields is None for card in self.cards], bool)
        joined = b"".join(card.body[: 8 * fields].ljust(8 * fields) for card in self.cards if card.fields is None)
        text[small] = np.frombuffer(joined, np.uint8).reshape(int(small.sum()), fields, 8)
        rows = [(card.fields[:fields] + [b""] * fields)[:fields] for card in self.cards if card.fields is not None]
        for row, k in zip(rows, np.flatnonzero(~small).tolist(), strict=True):
            if max(map(len, row), default=0) > LONGEST_FIELD:
                raise self.error(k, f"a field of {self.name} has more than {LONGEST_FIELD} characters. Shorten it.")
        width = max((len(each) for row in rows for each in row), default=0)
        if width > 8:
            text = np.concatenate([text, np.full((*text.shape[:2], width - 8), ord(" "), np.uint8)], axis=2)
        joined = b"".join(each.ljust(text.shape[2]) for row in rows for each in row)
        text[~small] = np.frombuffer(joined, np.uint8).reshape(len(rows), *text.shape[1:])
        return text

    def whole(self, first: int, after: int | None = None, blank: int | None = None) -> np.ndarray:
        """Whole numbers in one field (n,), or in several (n, fields); fields count from 0. Blank ones are `blank`, or wrong."""
        return self._numbers(whole_numbers, "whole number", first, after, blank)

    def real(self, first: int, after: int | None = None, blank: float | None = None) -> np.ndarray:
        """Real numbers in one field (n,), or in several (n, fields), as `whole`."""
        return self._numbers(real_numbers, "number", first, after, blank)

    def _numbers(
        self, read: Callable[[np.ndarray], FieldNumbers], what: str, first: int, after: int | None, blank: float | None
    ) -> np.ndarray:
        found = read(self._text[:, first : first + 1 if after is None else after])
        values = np.where(found.blank, blank or 0, found.values)
        wrong = found.wrong | (found.blank if blank is None else False)
        missing = min(self._fields, first + 1 if after is None else after) - first - values.shape[1]
        if missing:
            values = np.pad(values, ((0, 0), (0, missing)), constant_values=blank or 0)
            wrong = np.pad(wrong, ((0, 0), (0, missing)), constant_values=blank is None)
        if wrong.any():
            row, column = (int(k) for k in np.argwhere(wrong)[0])
            where = f"{_field(first + column)} of {self.name}"
            raise self.error(row, f"{where} holds no {what}. Write one there, within its columns.")
        return values[:, 0] if after is None else values

    def blank(self, field: int) -> np.ndarray:
        """Whether a field is blank, (n,)."""
        if field >= self._text.shape[1]:
            return np.ones(len(self.cards), bool)
        return (self._text[:, field] == ord(" ")).all(axis=1)

    def word(self, row: int, field: int) -> str:
        """Text of one field in capitals."""
        return (self.cards[row].words() + [""] * field)[field]

    def error(self, row: int, what: str) -> InputError:
        """Error saying that something is wrong with one of the cards."""
        return self.lines.error(self.cards[row].line, what)

    def place(self, row: int) -> str:
        """Position of one of the cards, in words."""
        return self.lines.place(self.cards[row].line)


def _field(k: int) -> str:
    """Name of field k behind the name of a card, as manuals count them."""
    return f"field {k % 8 + 2}" + (f" of continuation {k // 8}" if k >= 8 else "")
