"""One defect in a valid deck, which is then to be refused by the line that has it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from random import Random

from tests.foreign_decks.abaqus.elements import SHAPES
from tests.foreign_decks.abaqus.files import folded
from tests.foreign_decks.abaqus.writing import MARK, Chunk
from tests.foreign_decks.abaqus_decks import CARRIERS, Deck

SECRET = "qxsecret"
"""Part of every word of a deck that is not one of the format: no error may quote it."""
NO_NUMBERS = (
    "2.0abc",
    "1_0.0",
    "0x10",
    "nan",
    "inf",
    "-inf",
    "1e999",
    "--1",
    "1 2",
    "２.5",
    "1.0e",
    "1.5+3",
    f"{SECRET}",
    "1;2",
    "1.2.3",
    "1d",
    "2,5",
)
NO_LABELS = ("1.5", "0", "-3", "99999999999", "1000000000", f"{SECRET}", "1e3", "٣", "0x7", "1_0", "")
"""What numbers of nodes are not, of which some digits are none of ASCII."""


@dataclass
class Defect:
    """What is wrong with a deck, and what the error is to say."""

    name: str
    break_it: Callable[[Random, Deck], bool]  # changes the chunks and marks lines; whether the deck has what is to be broken
    match: str  # part of the message


def broken(rng: Random, deck: Deck, defect: Defect) -> Deck | None:
    """The deck with the defect; None if it has no place for it."""
    if not defect.break_it(rng, deck):
        return None
    deck.files = folded(rng, deck.chunks, deck.odd, set())
    return deck


def keyword(chunk: Chunk) -> str:
    """The keyword of a chunk without blanks, in capitals."""
    return "".join(chunk.head[0].strip(" *").split(",")[0].split()).upper()


def of(rng: Random, deck: Deck, *names: str) -> Chunk | None:
    """One of the chunks with such a keyword."""
    found = [chunk for chunk in deck.chunks if keyword(chunk) in names and "left_out" not in " ".join(chunk.head).lower()]
    return rng.choice(found) if found else None


def data_lines(chunk: Chunk) -> list[int]:
    """Places of the data lines that hold something."""
    return [k for k, line in enumerate(chunk.data) if line.strip() and not line.lstrip().startswith("**")]


def mark_head(chunk: Chunk) -> None:
    """The error is to name the keyword line."""
    chunk.head = [chunk.head[0] + MARK, *chunk.head[1:]]


def insert(rng: Random, deck: Deck, chunk: Chunk, after: tuple[str, ...] = ("ELEMENT", "ELGEN")) -> bool:
    """Put a chunk behind the last one with such a keyword."""
    places = [k for k, each in enumerate(deck.chunks) if keyword(each) in after]
    if places:
        deck.chunks.insert(places[-1] + 1, chunk)
    return bool(places)


def added(*lines: str, after: tuple[str, ...] = ("ELEMENT", "ELGEN")) -> Callable[[Random, Deck], bool]:
    """A defect that is a block of its own, one line of which is marked."""

    def break_it(rng: Random, deck: Deck) -> bool:
        return insert(rng, deck, Chunk([lines[0]], [*lines[1:]]), after)

    return break_it


def unknown_type(rng: Random, deck: Deck) -> bool:
    """*ELEMENT with a type that there is not."""
    name = rng.choice(["C3D9", "C3D8X9", f"{SECRET}8", "HEXA", "CPS5", "S7", "3D8"])
    return insert(rng, deck, Chunk([f"*ELEMENT, TYPE={name}{MARK}"], ["900001, 1, 2, 3"]))


def wrong_number(rng: Random, deck: Deck) -> bool:
    """A coordinate that is no number."""
    chunk = of(rng, deck, "NODE")
    if chunk is None or not data_lines(chunk):
        return False
    k = rng.choice(data_lines(chunk))
    text = rng.choice(NO_NUMBERS)
    label = chunk.data[k].split(",")[0]
    fields = [label, "1.25", "0.5", "7.75"]
    fields[rng.randint(1, 2 if text == "2,5" else 3)] = text
    chunk.data[k] = ", ".join(fields) + MARK
    return True


def wrong_label(rng: Random, deck: Deck) -> bool:
    """A number of a node that is none."""
    chunk = of(rng, deck, "NODE")
    if chunk is None or not data_lines(chunk):
        return False
    k = rng.choice(data_lines(chunk))
    chunk.data[k] = ", ".join([rng.choice(NO_LABELS), "1.25", "0.5", "7.75"]) + MARK
    return True


def wrong_element_field(rng: Random, deck: Deck) -> bool:
    """A node of an element that is no whole number."""
    chunk = of(rng, deck, "ELEMENT")
    if chunk is None:
        return False
    k = rng.choice(data_lines(chunk))
    fields = chunk.data[k].rstrip(", ").split(",")
    fields[rng.randrange(len(fields))] = rng.choice([each for each in NO_LABELS if each])
    chunk.data[k] = ",".join(fields) + "," * chunk.data[k].rstrip().endswith(",") + MARK
    return True


def one_node_less(rng: Random, deck: Deck) -> bool:
    """The last element of a block lacks a node, or has one too many."""
    chunk = of(rng, deck, "ELEMENT")
    if chunk is None:
        return False
    lines = data_lines(chunk)
    text = chunk.data[lines[-1]].rstrip(", \t")
    if rng.random() < 0.5 and "," in text:
        chunk.data[lines[-1]] = text.rpartition(",")[0]
    else:
        chunk.data[lines[-1]] = text + ", 1"
    for k in lines:
        chunk.data[k] += MARK
    return True


def missing_node(rng: Random, deck: Deck) -> bool:
    """An element names a node that there is not."""
    chunk = of(rng, deck, "ELEMENT")
    if chunk is None or deck.features & {"elements given twice", "C3D8I with 11 nodes"}:
        return False
    line = data_lines(chunk)[-1]
    text = chunk.data[line].rstrip(", \t")
    if "," not in text:
        return False
    chunk.data[line] = text.rpartition(",")[0] + ", 999999998"
    mark_head(chunk)
    return True


def carrier(rng: Random, deck: Deck) -> bool:
    """Elements with mass or stiffness beside solids, which nobody leaves out."""
    if not deck.solid or deck.leave_out or not deck.features & {"flat", "one_part"}:
        return False
    if {*SHAPES.values()} & {*deck.truth.left_out}:  # which name faces in decks without sections alone
        return False
    name = rng.choice([*CARRIERS])
    count, section, rows = CARRIERS[name]
    nodes = deck.some_nodes[:count]
    if not insert(rng, deck, Chunk([f"*ELEMENT, TYPE={name}, ELSET={SECRET}{MARK}"], [", ".join(["899999", *map(str, nodes)])])):
        return False
    place = next(k for k, each in enumerate(deck.chunks) if SECRET in each.head[0])
    deck.chunks.insert(place + 1, Chunk([f"*{section}, ELSET={SECRET}"], [", ".join(row) for row in rows]))
    return True


def no_size(name: str) -> Callable[[Random, Deck], bool]:
    """An element of mass or inertia that nothing says the size of."""

    def break_it(rng: Random, deck: Deck) -> bool:
        flat = bool(deck.features & {"flat", "one_part"})
        head = f"*ELEMENT, TYPE={name}, ELSET={SECRET}{MARK}"
        return flat and insert(rng, deck, Chunk([head], [f"900001, {deck.some_nodes[0]}"]))

    return break_it


def spherical(rng: Random, deck: Deck) -> bool:
    """Nodes in spherical coordinates, or ones that there are not."""
    chunk = of(rng, deck, "NODE")
    if chunk is None or any("SYSTEM" in line.upper() for line in chunk.head):
        return False
    chunk.head = [f"*NODE, SYSTEM={rng.choice(['S', 's', SECRET])}{MARK}"]
    return True


def without(name: str, of_end: str) -> Callable[[Random, Deck], bool]:
    """A part, assembly or instance without its end."""

    def break_it(rng: Random, deck: Deck) -> bool:
        begins = [k for k, each in enumerate(deck.chunks) if keyword(each) == name]
        if not begins:
            return False
        end = next(k for k, each in enumerate(deck.chunks) if keyword(each) == of_end and k > begins[-1])
        del deck.chunks[end]
        if name == "PART" and any(keyword(each) == "ASSEMBLY" for each in deck.chunks):
            mark_head(next(each for each in deck.chunks if keyword(each) == "ASSEMBLY"))
        elif name == "INSTANCE":
            mark_head(next(each for each in deck.chunks[end:] if keyword(each) == "ENDASSEMBLY"))
        else:
            mark_head(deck.chunks[begins[-1]])
        return True

    return break_it


def no_assembly(rng: Random, deck: Deck) -> bool:
    """Two parts, and nothing says where they are."""
    chunk = of(rng, deck, "ASSEMBLY")
    if chunk is None or "two_parts" not in deck.features:
        return False
    first = deck.chunks.index(chunk)
    last = next(k for k, each in enumerate(deck.chunks) if keyword(each) == "ENDASSEMBLY")
    del deck.chunks[first : last + 1]
    return True


def part_twice(rng: Random, deck: Deck) -> bool:
    """Two parts of one name."""
    if of(rng, deck, "PART") is None:
        return False
    deck.chunks.insert(1 if keyword(deck.chunks[0]) == "HEADING" else 0, Chunk(["*PART, NAME=BAR"], ["*END PART"]))
    mark_head(next(each for each in deck.chunks if keyword(each) == "PART" and each.head != ["*PART, NAME=BAR"]))
    return True


def in_head(name: str, *words: str) -> Callable[[Random, Deck], bool]:
    """A keyword line that is replaced by another one."""

    def break_it(rng: Random, deck: Deck) -> bool:
        chunk = of(rng, deck, name)
        if chunk is None:
            return False
        chunk.head = [rng.choice(words) + MARK]
        return True

    return break_it


def unknown_leave_out(rng: Random, deck: Deck) -> bool:
    """leave_out names a type that the deck does not have."""
    deck.leave_out |= {rng.choice(["CONM2", "S9R5", "DASHPOTA"])}
    return True


def flat_only(break_it: Callable[[Random, Deck], bool]) -> Callable[[Random, Deck], bool]:
    """The same in decks without parts alone."""
    return lambda rng, deck: "flat" in deck.features and break_it(rng, deck)


ASSEMBLY = ("ENDINSTANCE",)
DEFECTS = (
    Defect(
        "a keyword that is not known", added(f"*{SECRET}, name={SECRET}{MARK}", f"1, {SECRET}"), "none of those that are known"
    ),
    Defect("a misspelled keyword", added(f"*SOLID SECTIO, ELSET={SECRET}{MARK}"), "none of those that are known"),
    Defect("nodes in plural", added(f"*NODES{MARK}", "1, 2., 3., 4."), "none of those that are known"),
    Defect("shells with a misspelled section", added(f"*SHELL SECTON, ELSET={SECRET}{MARK}"), "none of those that are known"),
    Defect("a type that is not known", unknown_type, "element type is none of those that are known"),
    Defect("a type of solids that is not read", added(f"*ELEMENT, TYPE=C3D5{MARK}", "900001, 1, 2, 3, 4, 5"), "C3D5"),
    Defect("a type of axisymmetric solids", added(f"*ELEMENT, TYPE=CAX8R{MARK}", "900001, 1, 2, 3, 4, 5, 6, 7, 8"), "CAX8R"),
    Defect("no type", added(f"*ELEMENT, ELSET={SECRET}{MARK}", "1, 2, 3, 4, 5"), "needs the parameter TYPE"),
    Defect("elements with OFFSET", added(f"*ELEMENT, TYPE=C3D4, OFFSET=10{MARK}", "1, 2, 3, 4, 5"), "OFFSET"),
    Defect("an element that carries", carrier, "carry mass or stiffness"),
    Defect("a coordinate that is no number", wrong_number, "a field is no number|a unit normal"),
    Defect("a node whose number is none", wrong_label, "no whole number|no number of a node"),
    Defect("a node of an element that is no number", wrong_element_field, "no whole number|no number of a node"),
    Defect("an element with another number of nodes", one_node_less, "an element of this type has"),
    Defect("a node that there is not", missing_node, "names node 999999998, which the deck does not have"),
    Defect("spherical coordinates", spherical, "spherical or of a system that is not known"),
    Defect("a set of a set that is not known", added(f"*NSET, NSET={SECRET}1", f"1, {SECRET}2{MARK}"), "names a set"),
    Defect("an element set of one that is not known", added(f"*ELSET, ELSET={SECRET}1", f"{SECRET}2{MARK}"), "names a set"),
    Defect(
        "nodes of an element set that is not known",
        added(f"*NSET, NSET={SECRET}1, ELSET={SECRET}2{MARK}"),
        "names an? (element )?set",
    ),
    Defect("a set without a name", added(f"*NSET, GENERATE{MARK}", "1, 2"), "needs the parameter NSET"),
    Defect("a range that falls", added(f"*NSET, NSET={SECRET}, GENERATE", f"9, 3{MARK}"), "numbers go from 9 to 3"),
    Defect("a range without a step", added(f"*ELSET, ELSET={SECRET}, GENERATE", f"1, 3, 0{MARK}"), "in steps of 0"),
    Defect("a range of four numbers", added(f"*NSET, NSET={SECRET}, GENERATE", f"1, 3, 1, 5{MARK}"), "has 4 fields"),
    Defect("a set with an empty field", added(f"*NSET, NSET={SECRET}", f"1,,2{MARK}"), "empty field"),
    Defect("a set with a number that is none", added(f"*NSET, NSET={SECRET}", f"1, -2{MARK}"), "-2 is no number of a node"),
    Defect("a surface of a set that is not known", added(f"*SURFACE, NAME={SECRET}", f"{SECRET}9, S1{MARK}"), "names a set"),
    Defect("a part without an end", without("PART", "ENDPART"), "has no end|stands within another"),
    Defect("an assembly without an end", without("ASSEMBLY", "ENDASSEMBLY"), "has no end"),
    Defect("an instance without an end", without("INSTANCE", "ENDINSTANCE"), "stands where no \\*ASSEMBLY|within another"),
    Defect("an end without a beginning", flat_only(added(f"*END PART{MARK}")), "where no \\*PART has begun"),
    Defect("an instance outside of an assembly", flat_only(added(f"*INSTANCE, NAME=a, PART=b{MARK}")), "outside of \\*ASSEMBLY"),
    Defect("a part without a name", flat_only(added(f"*PART{MARK}")), "needs the parameter NAME"),
    Defect("two parts without an assembly", no_assembly, "has 2 parts and no \\*ASSEMBLY"),
    Defect("two parts of one name", part_twice, "two parts of this name"),
    Defect(
        "two instances of one name", added(f"*INSTANCE, NAME=BAR-1, PART=bar{MARK}", after=ASSEMBLY), "two instances of this name"
    ),
    Defect(
        "an instance of no part", in_head("INSTANCE", f"*INSTANCE, NAME=a, PART={SECRET}", "*INSTANCE, NAME=a"), "names no part"
    ),
    Defect(
        "a placement of six numbers",
        added(f"*INSTANCE, NAME=a, PART=bar{MARK}", "1.", "1., 2., 3., 4., 5., 6.", after=ASSEMBLY),
        "a placement is a line",
    ),
    Defect(
        "an axis without direction",
        added(f"*INSTANCE, NAME=a, PART=bar{MARK}", "1.", "1., 2., 3., 1., 2., 3., 90.", after=ASSEMBLY),
        "are the same",
    ),
    Defect("a set of no instance", added(f"*NSET, NSET=a, INSTANCE={SECRET}", "1", after=ASSEMBLY), "names an instance"),
    Defect("a local system on one line", added(f"*SYSTEM{MARK}", "0., 0., 0., 1., 0., 0.", "2., 0., 0."), "on one line"),
    Defect("a curved row of nodes", added(f"*NGEN, LINE=C{MARK}", "1, 3, 1, 2"), "\\*NGEN with LINE"),
    Defect("a row that misses its end", added("*NGEN", f"1, 4, 2{MARK}"), "does not lead"),
    Defect("layers between sets that are not known", added("*NFILL", f"{SECRET}, {SECRET}2, 3, 10{MARK}"), "names a set"),
    Defect("mirrored nodes", added(f"*NCOPY, OLD SET={SECRET}, CHANGE NUMBER=1, REFLECT=LINE{MARK}"), "with REFLECT"),
    Defect("copied nodes without a change", added(f"*NCOPY, SHIFT, OLD SET={SECRET}{MARK}", "1., 0., 0."), "CHANGE NUMBER"),
    Defect("rows of an element that there is not", added("*ELGEN", f"999999997, 2{MARK}"), "names element 999999997"),
    Defect("copied elements of no set", added(f"*ELCOPY, OLD SET={SECRET}, ELEMENT SHIFT=1, SHIFT NODES=1{MARK}"), "names a set"),
    Defect("a mass without a size", no_size("MASS"), "no \\*MASS"),
    Defect("an inertia without a size", no_size("ROTARYI"), "no \\*ROTARY INERTIA"),
    Defect("a reinforcement", added(f"*REBAR, ELEMENT=CONTINUUM{MARK}", f"{SECRET}, 1., 1., 0."), "\\*REBAR stands for"),
    Defect(
        "mass spread over elements", added(f"*NONSTRUCTURAL MASS, ELSET={SECRET}{MARK}", "1."), "\\*NONSTRUCTURAL MASS stands for"
    ),
    Defect("an imperfection", added(f"*IMPERFECTION, FILE={SECRET}{MARK}", "1, 0.1"), "\\*IMPERFECTION stands for"),
    Defect("leave_out of what is not there", unknown_leave_out, "leave_out names"),
)
"""All defects."""
