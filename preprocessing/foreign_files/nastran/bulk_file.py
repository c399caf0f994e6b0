"""The reader of bulk data: everything in the file is part of the body, told as left out, or refused by its name and line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from preprocessing.foreign_files.contents import Elements, LeftOutContent, MeshContents
from preprocessing.foreign_files.nastran.cards import Cards, CardTable
from preprocessing.foreign_files.nastran.elements import (
    MOST_PROPERTIES,
    CardBlock,
    blocks_of,
    only_name,
    properties_of,
    property_groups,
    refuse_twice,
    set_groups,
)
from preprocessing.foreign_files.nastran.grid import Grid, grid_of
from preprocessing.foreign_files.nastran.lines import (
    CARRYING,
    OTHERS,
    ROD_PROPERTIES,
    RODS,
    SHELL_PROPERTIES,
    SHELLS,
    SOLIDS,
    TAKEN,
    WHY,
    bulk_lines,
)
from preprocessing.foreign_files.nastran.masses import MASSES, given_masses, point_masses, systems_of
from toolkit.foundation.errors import InputError

CHOSEN = "left out by leave_out in [mesh]"
NAMING = "it has no property in the file and is a face or edge of the body: it names a place, as a group"


class BulkBody(NamedTuple):
    """Elements of a bulk file: those of the body, and those that only name places of it."""

    body: list[CardBlock]  # of which it consists
    naming: list[CardBlock]  # which only name its faces and edges

    @property
    def all(self) -> list[CardBlock]:
        """All elements, those of the body first."""
        return [*self.body, *self.naming]


def read_bulk(path: Path, leave_out: frozenset[str]) -> MeshContents:
    """Contents of a bulk file and of the files that it includes.

    Raises
    ------
    InputError
        A card is wrong, not known, or carries mass or stiffness and cannot be part of a body.
    """
    lines, which = bulk_lines(path)
    cards = Cards.of(lines, which)
    _refuse_unknown(cards, leave_out)
    _refuse_absent(cards, leave_out)
    masses = given_masses(cards, leave_out)
    grid = grid_of(cards, systems_of(masses))
    found = _body(cards, grid, leave_out)
    in_body = np.zeros(len(grid.labels), bool)
    for block in found.body:
        in_body[block.nodes] = True
    sets, unread = set_groups(cards, grid, found.all)
    return MeshContents(
        grid.points,
        _cells(found.body),
        [*property_groups(found.body, found.naming), *sets],
        grid.labels,
        point_masses(masses, cards, grid, in_body, _mass_factor(cards)),
        [*_left_out(cards, leave_out), *_naming(found.naming), *grid.left_out(), *unread],
        list(_remarks(cards, found, bool(masses))),
    )


def _refuse_unknown(cards: Cards, leave_out: frozenset[str]) -> None:
    """Refuse the first card that is not known: it may carry mass."""
    unknown = [each[0] for name, each in cards.by_name.items() if name not in {*TAKEN, *CARRYING, *WHY, *OTHERS, *leave_out}]
    if unknown:
        raise cards.lines.error(
            min(card.line for card in unknown),
            "this card is not known here, and may carry mass or stiffness. Take it out of the file, or name it in leave_out of [mesh].",
        )


def _refuse_absent(cards: Cards, leave_out: frozenset[str]) -> None:
    """Refuse names of leave_out that no card has: a wrong spelling would leave nothing out."""
    if absent := sorted(leave_out - set(cards.by_name)):
        raise InputError(
            f"leave_out in [mesh] names {', '.join(map(repr, absent))}, and {str(cards.lines.main)!r} has no card of this name. "
            "Take it out of leave_out, or fix its spelling."
        )


def _body(cards: Cards, grid: Grid, leave_out: frozenset[str]) -> BulkBody:
    """Elements of the body: solids, or shells where there are none.

    Raises
    ------
    InputError
        Something else carries mass or stiffness.
    """
    solids, shells, rods = (blocks_of(cards, grid, kinds, leave_out) for kinds in (SOLIDS, SHELLS, RODS))
    refuse_twice([*solids, *shells, *rods])
    body, others = (solids, [*shells, *rods]) if solids else (shells, rods)
    naming, carrying = [], [_count(cards, name) for name in sorted(CARRYING & set(cards.by_name) - leave_out)]
    for block in others:
        properties = _properties(cards, ROD_PROPERTIES if block.card in RODS else SHELL_PROPERTIES)
        names = only_name(block, body, grid, properties)
        if names.any():
            naming.append(block.part(names))
        if not names.all():
            carrying.append((block.card, int((~names).sum()), block.place(int(np.argmin(names)))))
    if carrying:
        raise _refusal(cards, carrying, bool(solids))
    return BulkBody(body, naming)


def _count(cards: Cards, name: str) -> tuple[str, int, str]:
    """Name, number and place of the first of the cards of a name."""
    found = cards.by_name[name]
    return name, len(found), cards.lines.place(found[0].line)


def _refusal(cards: Cards, carrying: Sequence[tuple[str, int, str]], solids: bool) -> InputError:
    """Error saying that these cards, each with its number and first place, are no part of such a body."""
    what = "; ".join(f"{number} {name}, the first in {place}" for name, number, place in carrying)
    names = ", ".join(f'"{name}"' for name in dict.fromkeys(name for name, _, _ in carrying))
    consists = f"solids ({', '.join(SOLIDS)}) and masses (CONM2)" if solids else "shells in one plane and masses (CONM2)"
    return InputError(
        f"{str(cards.lines.main)!r} has cards that carry mass or stiffness and are no part of the body, which consists of {consists}: "
        f"{what}. Model them by these, or leave them out on purpose: leave_out = [{names}] in [mesh]."
    )


def _properties(cards: Cards, names: Sequence[str]) -> set[int]:
    """Numbers of the properties that such cards define."""
    tables = [CardTable(name, cards.by_name[name], 1, cards.lines, rest=True) for name in names if name in cards.by_name]
    return {number for table in tables for number in table.whole(0).tolist()}


def _cells(blocks: Sequence[CardBlock]) -> Elements:
    """The elements by kind."""
    kinds = dict.fromkeys(block.kind for block in blocks)
    return [(kind, np.concatenate([block.nodes for block in blocks if block.kind == kind])) for kind in kinds]


def _mass_factor(cards: Cards) -> float:
    """Factor of every mass of the file, from PARAM, WTMASS."""
    factor = 1.0
    for card in cards.by_name.get("PARAM", []):
        if card.words()[0] == "WTMASS":
            factor = float(CardTable("PARAM", [card], 2, cards.lines, rest=True).real(1)[0])
            if not factor > 0:
                raise cards.lines.error(card.line, "PARAM WTMASS is to be above 0, as it multiplies masses. Write such a number.")
    return factor


def _left_out(cards: Cards, leave_out: frozenset[str]) -> Iterator[LeftOutContent]:
    """Entries that are left out on purpose, or are no part of a body and still worth a word."""
    for name, found in cards.by_name.items():
        if name in leave_out:
            yield LeftOutContent(name, len(found), CHOSEN)
        elif name in WHY:
            yield LeftOutContent(name, len(found), WHY[name])


def _naming(blocks: Sequence[CardBlock]) -> list[LeftOutContent]:
    return [LeftOutContent(block.card, len(block.labels), NAMING) for block in blocks]


def _remarks(cards: Cards, found: BulkBody, masses: bool) -> Iterator[str]:
    """Remarks on the reading that the user should know."""
    if (n := _materials(cards, found.body)) > 1:
        yield f"The elements of the file have {n} materials; those of the body have the one of body.toml."
    if both := properties_of(found.body) & properties_of(found.naming):
        names = ", ".join(f"pid {k}" for k in sorted(both)[:5])
        yield f"Elements of the body and faces or edges of it have one property; groups such as {names} are of the body only."
    if len(properties_of(found.all)) > MOST_PROPERTIES:
        yield f"The elements have more than {MOST_PROPERTIES} properties, which are no groups."
    if masses and (factor := _mass_factor(cards)) != 1.0:
        yield f"PARAM WTMASS multiplies the masses of {' and '.join(MASSES)} by {factor:g}, as it does in Nastran."
    if cards.long_lines:
        yield f"{cards.long_lines} lines have more than 80 characters, and Nastran does not read the rest of them."
    if cards.end is not None and cards.after_end:
        yield f"What follows ENDDATA ({cards.lines.place(cards.end)}) is not read, as in Nastran."


def _materials(cards: Cards, body: Sequence[CardBlock]) -> int:
    """Number of materials that the elements have, as far as cards give them.

    Raises
    ------
    InputError
        A property is that of a fluid.
    """
    used = properties_of(body)
    numbers: set[int] = set()
    for name in ("PSOLID", "PSHELL"):
        table = CardTable(name, cards.by_name.get(name, []), 7, cards.lines, rest=True)
        for row, (number, material) in enumerate(zip(table.whole(0).tolist(), table.whole(1, blank=0).tolist(), strict=True)):
            if number in used and name == "PSOLID" and table.word(row, 6) in ("PFLUID", "FFLUID"):
                raise table.error(row, "PSOLID is that of a fluid, and bodies are solids. Take its elements out.")
            if number in used:
                numbers.add(material)
    table = CardTable("MAT1", cards.by_name.get("MAT1", []), 5, cards.lines, rest=True)
    values = dict(zip(table.whole(0).tolist(), map(tuple, table.real(1, 5, blank=0.0).tolist()), strict=True))
    return len({values.get(number, (number,)) for number in numbers})
