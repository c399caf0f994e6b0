"""Random valid bulk data of Nastran whose truth is known by construction: places, elements, masses and groups, in every way of writing.

The truth comes from the numbers as they are written, by formulas of the manuals of their own here, and never from the reader.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from decimal import Decimal

import numpy as np

CORNERS = {"CTETRA": 4, "CHEXA": 8, "CPENTA": 6, "CTRIA3": 3, "CQUAD4": 4, "CTRIA6": 3, "CQUAD8": 4}
RING = {3: ((0, 1), (1, 2), (2, 0)), 4: ((0, 1), (1, 2), (2, 3), (3, 0))}
UPRIGHT = {n: tuple((k, n + k) for k in range(n)) for n in RING}
TOP = {n: tuple((n + a, n + b) for a, b in RING[n]) for n in RING}
BY_MANUAL = {
    "CTETRA": ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)),
    "CHEXA": (*RING[4], *UPRIGHT[4], *TOP[4]),
    "CPENTA": (*RING[3], *UPRIGHT[3], *TOP[3]),
    "CTRIA6": RING[3],
    "CQUAD8": RING[4],
}
"""Card -> edges in the order of their middles, by the Quick Reference Guide."""
BY_MESHIO = {**BY_MANUAL, "CHEXA": (*RING[4], *TOP[4], *UPRIGHT[4]), "CPENTA": (*RING[3], *TOP[3], *UPRIGHT[3])}
"""The same in the order of VTK, which meshio has."""
KINDS = {
    ("CTETRA", False): "tetra", ("CTETRA", True): "tetra10", ("CHEXA", False): "hexahedron", ("CHEXA", True): "hexahedron20",
    ("CPENTA", False): "wedge", ("CPENTA", True): "wedge15", ("CTRIA3", False): "triangle", ("CQUAD4", False): "quad",
    ("CTRIA6", True): "triangle6", ("CQUAD8", True): "quad8",
}  # fmt: skip
HARMLESS = [
    ["PARAM", "POST", "-1"], ["MAT1", "1", "2.1+11", "", ".3", "7800."], ["EIGRL", "10", "", "", "6"], ["MAT9", "7", "1.", "2."],
    ["TABLED1", "9", *[""] * 7, "0.", "1.", "2.", "3.", "ENDT"], ["ASET1", "123", "1", "THRU", "5"], ["PARAM", "GRDPNT", "0"],
]  # fmt: skip
TOLD = [["SPC1", "1", "123456", "1", "2", "3"], ["FORCE", "2", "1", "0", "5.", "1.", "0.", "0."], ["PLOAD4", "3", "1", "1.E6"],
        ["SPCADD", "5", "1"], ["GRAV", "6", "", "9.81", "0.", "0.", "-1."], ["PLOTEL", "900001", "1", "2"], ["SPOINT", "990001"],
        ["MPC", "3", "1", "1", "1.", "2", "1", "-1."]]  # fmt: skip


@dataclass
class Mass:
    """A concentrated mass in the basic system."""

    mass: float
    place: np.ndarray
    inertia: np.ndarray  # (3, 3)
    carriers: tuple[int, ...]
    rigid: bool


@dataclass
class Deck:
    """Files, the first of which is the main one, and what they say."""

    files: dict[str, bytes] = field(default_factory=dict)
    points: dict[int, np.ndarray] = field(default_factory=dict)  # label -> place
    elements: dict[str, list[tuple[int, ...]]] = field(default_factory=dict)  # kind -> labels of nodes, in the order of meshio
    masses: list[Mass] = field(default_factory=list)
    groups: dict[str, set[int]] = field(default_factory=dict)  # name -> labels of nodes
    left_out: set[str] = field(default_factory=set)


@dataclass
class System:
    """A coordinate system: kind, origin and unit vectors."""

    kind: str
    origin: np.ndarray
    axes: np.ndarray  # rows are x, y and z

    def place(self, a: float, b: float, c: float) -> np.ndarray:
        """Where coordinates are in the basic system."""
        if self.kind == "C":
            a, b = a * math.cos(b * math.pi / 180), a * math.sin(b * math.pi / 180)
        if self.kind == "S":
            r, polar, around = a, b * math.pi / 180, c * math.pi / 180
            a, b, c = r * math.sin(polar) * math.cos(around), r * math.sin(polar) * math.sin(around), r * math.cos(polar)
        return self.origin + a * self.axes[0] + b * self.axes[1] + c * self.axes[2]


class Writer:
    """Cards as a user or a program may write them."""

    def __init__(self, rng: np.random.Generator, judged: bool) -> None:
        self.rng = rng
        self.judged = judged  # only ways that pyNastran 1.4.1 reads, too
        self.marks = 0
        self.style = str(rng.choice(["small", "large", "free", "wide", "tab", "any", "any"]))

    def chance(self, part: float) -> bool:
        """Whether something happens that happens in this part of all cases."""
        return bool(self.rng.random() < part)

    def real(self, low: float, high: float, width: int = 8) -> tuple[str, float]:
        """A number as text of at most so many characters, and its value; zero may be blank."""
        if self.chance(0.1):
            return str(
                self.rng.choice(["", "0.", "0.0", ".0", "-0.", "0.E0", "0"] if not self.judged else ["", "0.", "0.0", "-0."])
            ), 0.0
        digits = int(self.rng.integers(1, 5 if width == 8 else 11))
        number = Decimal(f"{self.rng.uniform(low, high):.{digits}g}")
        ways = [f"{number:f}" if "." in f"{number:f}" else f"{number:f}."]
        sign, figures, power = number.as_tuple()
        text, minus, shift = "".join(map(str, figures)), "-" * sign, int(power) + len(figures) - 1
        mantissa = f"{text[0]}.{text[1:]}"
        ways += [f"{minus}{mantissa}{shift:+d}", f"{minus}{mantissa}E{shift}", f"{minus}{mantissa}D{shift:+03d}"]
        ways += [
            f"{minus}.{text}{shift + 1:+d}",
            f"{minus}{mantissa}e{shift:+d}",
            re.sub(r"^(-?)0\.(?=\d)", r"\1.", ways[0]),
            "+" * (1 - sign) + ways[0],
        ]
        ways = [each for each in ways if len(each) <= width]
        return (str(self.rng.choice(ways)), float(number)) if ways else self.real(low, high, width)

    def card(self, fields: list[str]) -> list[str]:
        """Lines of one card."""
        name, *data = [str(each) for each in fields]
        while data and not data[-1]:
            data.pop()
        wide = max(map(len, data), default=0) > 8
        style = self.style if self.style != "any" else str(self.rng.choice(["small", "large", "free", "wide", "tab"]))
        if wide and style in ("small", "tab"):
            style = "large"
        data += [""] * (-len(data) % (4 if style in ("large", "wide") else 8))
        lines = getattr(self, f"_{style}")(name, data)
        if self.chance(0.2):
            lines = [line.lower() for line in lines]
        if self.chance(0.1):
            lines[-1] = lines[-1].rstrip() + " $ a comment, with GRID 1 2 3"
        if self.chance(0.05):
            lines.insert(int(self.rng.integers(len(lines) + 1)), str(self.rng.choice(["$ comment", "", "   ", "$CHEXA,1,2,3"])))
        return lines

    def _mark(self) -> str:
        """A mark of seven characters or none."""
        self.marks += 1
        return str(self.rng.choice(["", "", f"M{self.marks}"]))

    def _fixed(self, name: str, data: list[str], width: int, star: str) -> list[str]:
        n, lines, mark = 64 // width, [], ""
        for k in range(0, max(len(data), 1), n):
            head = (name + star if k == 0 else (star or str(self.rng.choice(["+", " "] if not mark else ["+"]))) + mark).ljust(8)
            mark = self._mark() if k + n < len(data) else ""
            pad = [str.ljust, str.rjust][int(self.rng.integers(2))]
            body = "".join(pad(each, width) for each in data[k : k + n])
            end = ((star or "+") + mark) if mark or self.chance(0.3) else ""
            lines.append((head + body + end).rstrip() or head)
        return lines

    def _small(self, name: str, data: list[str]) -> list[str]:
        return self._fixed(name, data, 8, "")

    def _large(self, name: str, data: list[str]) -> list[str]:
        return self._fixed(name, data, 16, "*")

    def _tab(self, name: str, data: list[str]) -> list[str]:
        """Small fields by tabs."""
        if any(len(each) > 7 for each in [name, *data]):
            return self._small(name, data)
        return ["\t".join([name if k == 0 else "+", *data[k : k + 8]]).rstrip("\t") for k in range(0, max(len(data), 1), 8)]

    def _comma(self, name: str, data: list[str], n: int, star: str) -> list[str]:
        lines, mark = [], ""
        for k in range(0, max(len(data), 1), n):
            head = name + star if k == 0 else (star + mark if star else ("+" + mark if mark else str(self.rng.choice(["", "+"]))))
            mark = self._mark() if k + n < len(data) else ""
            own = data[k : k + n]
            if mark:
                own = [*own, (star or "+") + mark]
            else:
                while own and not own[-1]:
                    own.pop()
            lines.append(str(self.rng.choice([",", ", ", " ,"])).join([head, *own]))
        return lines

    def _free(self, name: str, data: list[str]) -> list[str]:
        return self._comma(name, data, 8, "")

    def _wide(self, name: str, data: list[str]) -> list[str]:
        return self._comma(name, data, 4, "*")


def bulk_deck(seed: int, judged: bool = False) -> Deck:
    """The deck of a seed; `judged` keeps to what pyNastran 1.4.1 reads, too."""
    return _Maker(seed, judged).made()


class _Maker:
    def __init__(self, seed: int, judged: bool) -> None:
        self.rng = np.random.default_rng([seed, int(judged)])
        self.writer = Writer(self.rng, judged)
        self.judged = judged
        self.deck = Deck()
        self.cards: list[list[str]] = []
        self.systems: dict[int, System] = {0: System("R", np.zeros(3), np.eye(3))}
        self.label = 0

    def made(self) -> Deck:
        """All of it."""
        self._systems()
        default = int(self.rng.choice(list(self.systems))) if self.writer.chance(0.3) else 0
        if default or self.writer.chance(0.1):
            self.cards.append(["GRDSET", "", str(default)])
        self.default = default
        plane = self.writer.chance(0.2)
        self._elements(plane)
        self._masses()
        self._sets()
        for told in (card for card in TOLD if self.writer.chance(0.2)):
            self.cards.append(told)
            self.deck.left_out.add(told[0])
        self.cards += [card for card in HARMLESS if self.writer.chance(0.3)]
        self._files()
        return self.deck

    def _reals(self, n: int, low: float, high: float) -> tuple[list[str], list[float]]:
        found = [self.writer.real(low, high, int(self.rng.choice([8, 8, 14]))) for _ in range(n)]
        return [text for text, _ in found], [value for _, value in found]

    def _systems(self) -> None:
        """Coordinate systems by points in each other, or by nodes."""
        for number in self.rng.choice(np.arange(1, 99), int(self.rng.integers(0, 5)), replace=False).tolist():
            kind = str(self.rng.choice(list("RCS")))
            reference = int(self.rng.choice(list(self.systems)))
            by_nodes = self.writer.chance(0.3)
            rows = [self._reals(3, -30.0, 60.0) for _ in range(3)]
            a, b, c = (self.systems[reference].place(*values) for _, values in rows)
            normal = np.cross(b - a, c - a)
            if np.linalg.norm(normal) <= 0.1 * np.linalg.norm(b - a) * np.linalg.norm(c - a) or np.linalg.norm(b - a) < 1:
                continue
            if by_nodes:
                self.default = 0
                nodes = [self._node(reference, texts, values, explicit=True) for texts, values in rows]
                self.cards.append([f"CORD1{kind}", str(number), *map(str, nodes)])
            else:
                self.cards.append([f"CORD2{kind}", str(number), str(reference), *(text for texts, _ in rows for text in texts)])
            z, y = (b - a) / np.linalg.norm(b - a), normal / np.linalg.norm(normal)
            self.systems[number] = System(kind, a, np.array([np.cross(y, z), y, z]))

    def _node(self, system: int, texts: list[str], values: list[float], explicit: bool = False) -> int:
        """A new node at coordinates of a system."""
        self.label += 1 if self.writer.chance(0.7) else int(self.rng.integers(1, 400))
        given = str(system) if explicit or system != self.default or self.writer.chance(0.5) else ""
        card = ["GRID", str(self.label), given, *texts]
        if not self.judged and self.writer.chance(0.05):
            self.cards.append(card)  # a copy counts for nothing
        self.cards.append(card)
        self.deck.points[self.label] = self.systems[system].place(*values)
        return self.label

    def _any_node(self) -> int:
        return self._node(int(self.rng.choice(list(self.systems))), *self._reals(3, -20.0, 80.0))

    def _elements(self, plane: bool) -> None:
        """Elements of nodes at random: a reader of files does not look at their shape."""
        names = ["CTRIA3", "CQUAD4", "CTRIA6", "CQUAD8"] if plane else ["CTETRA", "CHEXA", "CPENTA"]
        pool = [self._any_node() for _ in range(int(self.rng.integers(8, 20)))]
        middles: dict[frozenset[int], int] = {}
        self.numbers: list[int] = []
        for number in self.rng.choice(np.arange(1, 5000), int(self.rng.integers(1, 9)), replace=False).tolist():
            name = str(self.rng.choice(names))
            quadratic = name in ("CTRIA6", "CQUAD8") or (not plane and self.writer.chance(0.4))
            corners = self.rng.choice(pool, CORNERS[name], replace=False).tolist()
            nodes = {}
            for edge in BY_MANUAL[name] if quadratic else ():
                key = frozenset((corners[edge[0]], corners[edge[1]]))
                if key not in middles:
                    middles[key] = self._any_node()
                nodes[edge] = middles[key]
            own = str(int(self.rng.integers(1, 4))) if self.judged or self.writer.chance(0.9) else ""
            self.cards.append([name, str(number), own, *map(str, corners), *(str(nodes[edge]) for edge in nodes)])
            labels = (*corners, *(nodes[edge] for edge in (BY_MESHIO[name] if quadratic else ())))
            self.deck.elements.setdefault(KINDS[name, quadratic], []).append(labels)
            self.deck.groups.setdefault(f"pid {own or number}", set()).update(labels)
            self.numbers.append(number)
        self.body = sorted({node for of_kind in self.deck.elements.values() for labels in of_kind for node in labels})

    def _masses(self) -> None:
        """CONM2 on nodes of the body, or on others that RBE2 or RBE3 tie to it."""
        for k in range(int(self.rng.choice([0, 0, 1, 3]))):
            node, carriers, rigid = int(self.rng.choice(self.body)), (), True
            if self.writer.chance(0.5):
                node, carriers, rigid = self._tied(800_000 + k)
            straight = [number for number, system in self.systems.items() if system.kind == "R"]
            system = int(self.rng.choice([*straight, -1]))
            (mass_text, mass), (texts, centre) = self.writer.real(1.0, 900.0), self._reals(3, -2.0, 2.0)
            # Moments far above the products are those of some body.
            small = [self.writer.real(-0.2, 0.2) for _ in range(3)]
            large = [self.writer.real(1.0, 1.5) for _ in range(3)]
            inertia = [large[0], small[0], large[1], small[1], small[2], large[2]]
            if any(value == 0 for _, value in large) or self.writer.chance(0.4):
                inertia = [("", 0.0)] * 6
            (i11, i21, i22, i31, i32, i33) = (value for _, value in inertia)
            tensor = np.array([[i11, -i21, -i31], [-i21, i22, -i32], [-i31, -i32, i33]])
            axes = self.systems[max(system, 0)].axes.T
            place = np.array(centre) if system == -1 else self.deck.points[node] + axes @ np.array(centre)
            if mass or tensor.any():
                self.deck.masses.append(Mass(mass, place, axes @ tensor @ axes.T, carriers or (node,), rigid))
            row = ["CONM2", str(700_000 + k), str(node), str(system) if system else "", mass_text, *texts, ""]
            self.cards.append([*row, *(text for text, _ in inertia)])

    def _tied(self, number: int) -> tuple[int, tuple[int, ...], bool]:
        """A node of its own that one rigid element ties to the body."""
        node = self._any_node()
        carriers = self.rng.choice(self.body, int(self.rng.integers(2, 1 + min(12, len(self.body)))), replace=False).tolist()
        rigid = self.writer.chance(0.6)
        if rigid:
            self.cards.append(["RBE2", str(number), str(node), str(self.rng.choice(["123", "123456"])), *map(str, carriers)])
        else:
            self.cards.append(["RBE3", str(number), "", str(node), "123456", "1.", "123", *map(str, carriers)])
        self.deck.left_out.add("RBE2" if rigid else "RBE3")
        return node, tuple(carriers), rigid

    def _sets(self) -> None:
        """Sets of nodes, one by one or by their first and last."""
        if self.judged:
            return
        labels = list(self.deck.points)
        if self.writer.chance(0.4):
            some = self.rng.choice(labels, min(len(labels), 11), replace=False).tolist()
            self.cards.append(["SET1", "5", *map(str, some)])
            self.deck.groups["SET1 5"] = set(some)
        if self.writer.chance(0.4):
            low, high = sorted(self.rng.choice(labels, 2, replace=False).tolist())
            self.cards.append(["SET3", "6", "GRID", str(low), "THRU", str(high)])
            self.deck.groups["SET3 6"] = {label for label in labels if low <= label <= high}
        if self.writer.chance(0.3):
            self.cards.append(["SET3", "7", "ELEM", *map(str, self.numbers[:9])])
            self.deck.groups["SET3 7"] = set()

    def _files(self) -> None:
        """The cards, in any order and in several files."""
        order = self.rng.permutation(len(self.cards)) if self.writer.chance(0.5) else range(len(self.cards))
        written = [self.writer.card(self.cards[k]) for k in order]
        if not self.judged and self.writer.chance(0.2):
            written = self._apart(written)
        n = int(self.rng.choice([1, 1, 2, 3]))
        cuts = sorted(self.rng.integers(0, len(written) + 1, n - 1).tolist())
        parts = [[line for card in written[a:b] for line in card] for a, b in zip([0, *cuts], [*cuts, len(written)], strict=True)]
        head = ["SOL 103", "CEND", "TITLE = GRID 1", "SUBCASE 1", "BEGIN BULK"] if self.writer.chance(0.5) else ["BEGIN BULK"]
        tail = ["ENDDATA"] if self.judged or self.writer.chance(0.6) else []
        bare = not self.judged and self.writer.chance(0.2)
        main = [*([] if bare else head), *parts[0]]
        names = ["part1.blk", "deep/part2.inc"]
        for k, part in enumerate(parts[1:]):
            statement = self._include(names[k])
            nested = k == 1 and self.writer.chance(0.5)
            if nested:  # sought from the folder of the main file
                self.deck.files[names[0]] = self._ended([*self.deck.files[names[0]].decode().splitlines(), *statement])
            else:
                at = len(main)
                main[at:at] = statement
            self.deck.files[names[k]] = self._ended(part)
        self.deck.files = {"body.bdf": self._ended([*main, *tail]), **self.deck.files}

    def _include(self, name: str) -> list[str]:
        quote = str(self.rng.choice(["'", '"', ""] if not self.judged else ["'"]))
        word = "INCLUDE" if self.judged else str(self.rng.choice(["INCLUDE", "include", "Include"]))
        if quote and "/" in name and not self.judged and self.writer.chance(0.5):
            return [f"{word} {quote}deep/", f"      part2.inc{quote}"]
        return [f"{word} {quote}{name}{quote}"]

    def _ended(self, lines: list[str]) -> bytes:
        end = "\r\n" if not self.judged and self.writer.chance(0.15) else "\n"
        return (end.join(lines) + end).encode()

    def _apart(self, written: list[list[str]]) -> list[list[str]]:
        """Put a card of two lines in small format with its second line at the end of all, where its mark finds it."""
        for name in ("CHEXA", "CORD2R"):
            for k, lines in enumerate(written):
                if (
                    len(lines) == 2
                    and lines[0].startswith(name)
                    and not set(",\t$*") & set("".join(lines))
                    and lines[0][8:].strip()
                ):
                    marked = lines[0][:72].ljust(72) + "+FARAWAY"
                    return [*written[:k], [marked], *written[k + 1 :], ["+FARAWAY" + lines[1][8:]]]
        return written
