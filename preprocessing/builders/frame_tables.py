"""The tables of frame.toml, where its named nodes are, and beams that lie on each other or cross.

Two beams on one line count twice in mass and stiffness, which nobody means: this is refused. A node or a beam that touches another beam
without a common node is not connected with it. That may be meant (braces that pass each other), or be forgotten: this is told.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, FiniteFloat, model_validator

from preprocessing.builders.tables import InputTable, InterfaceName, Positive
from preprocessing.elements.section import SectionShape, circle, general, rectangle, tube

Coordinates = Annotated[list[FiniteFloat], Field(min_length=2, max_length=3)]
Triple = Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]
Pair = Annotated[list[FiniteFloat], Field(min_length=2, max_length=2)]
NAMED = InterfaceName
"""Names of nodes, sections and materials become parts of the names of parameters."""

DIMENSIONS: dict[str, dict[str, str]] = {
    "rectangle": {"thickness": "length", "width": "length"},
    "circle": {"diameter": "length"},
    "tube": {"diameter": "length", "wall": "length"},
    "general": {
        "area": "area",
        "I_y": "second_moment",
        "I_z": "second_moment",
        "J": "second_moment",
        "I_p": "second_moment",
    },
}
"""Kind of a section -> its numbers, and what they are, for their units."""
SHEAR_FACTORS = {"rectangle": 5 / 6, "circle": 9 / 10}
"""Kind of a section -> kappa (Reissner); that of a tube depends on its wall, from 0.5 if it is thin."""


class PolarNode(InputTable):
    """A node of a plane frame at a length and an angle from another one; both are design variables, `length_B` and `angle_B`."""

    start: str = Field(alias="from")  # name of a node
    length: Positive  # length
    angle: FiniteFloat = 0.0  # rad, from the x axis, counter-clockwise


class BeamTable(InputTable):
    """A straight beam between two nodes, of equal elements."""

    start: str = Field(alias="from")  # name of a node
    end: str = Field(alias="to")
    elements: Annotated[int, Field(ge=1, le=500)] = 4
    section: str  # name of a section
    orientation: Triple | None = (
        None  # in space, direction of the section's third axis, less its part along the beam; by default z, or x of a beam along z
    )


class FrameSection(InputTable):
    """A section by its dimensions, or by its numbers (`general`), and the material that it is made of.

    The third axis of a section is the orientation of its beam, the second one is perpendicular to that and to the beam: the width of a
    rectangle lies along the third, its thickness along the second: in the plane, where every section is a rectangle, the thickness lies
    in the plane and the width across it. I_y is int y_3^2 dA (bending about the second axis), I_z is
    int y_2^2 dA, J the torsion constant, and I_p the polar moment of the section's mass, I_y + I_z of a homogeneous section.
    """

    kind: Literal["rectangle", "circle", "tube", "general"]
    material: str  # name of a material
    thickness: Positive | None = None  # length; of a rectangle
    width: Positive | None = None  # length; of a rectangle
    diameter: Positive | None = None  # length; of a circle, outer one of a tube
    wall: Positive | None = None  # length; thickness of a tube's wall
    shear_factor: Annotated[float, Field(gt=0, le=1)] | None = (
        None  # kappa, with shear; by default 5/6 of a rectangle, 0.9 of a circle
    )
    area: Positive | None = None  # length^2
    I_y: Positive | None = None  # length^4, as the next three
    I_z: Positive | None = None
    J: Positive | None = None
    I_p: Positive | None = None
    fibres: list[Pair] | None = None  # of a general section: places y_2, y_3 whose stress is told; by default the centre

    @model_validator(mode="after")
    def _can_be_meant(self) -> FrameSection:
        own = set(DIMENSIONS[self.kind])
        given = {name for names in DIMENSIONS.values() for name in names if getattr(self, name) is not None}
        if given != own:
            raise ValueError(
                f"a {self.kind} has the numbers {', '.join(sorted(own))} (given: {', '.join(sorted(given)) or 'none'})"
            )
        if self.fibres is not None and (self.kind != "general" or not self.fibres):
            raise ValueError("fibres are one or more places of a general section; the others have theirs")
        if self.kind == "tube" and 2 * (self.wall or 0) > (self.diameter or 0):
            raise ValueError('the wall of a tube is at most half its diameter; write kind = "circle" for a full one')
        if self.kind == "general" and (self.I_p or 0) < abs((self.I_y or 0) - (self.I_z or 0)):
            raise ValueError(
                "an I_p below |I_y - I_z| belongs to no distribution of mass; I_y + I_z is that of a homogeneous section"
            )
        return self

    @property
    def dimensions(self) -> dict[str, float]:
        """Dimensions of the section by their names."""
        return {name: getattr(self, name) for name in DIMENSIONS[self.kind]}

    @property
    def kappa(self) -> float | None:
        """Shear factor, the part of the area that carries a shear force: as given, or as of full sections."""
        return SHEAR_FACTORS.get(self.kind) if self.shear_factor is None else self.shear_factor

    @property
    def shape(self) -> SectionShape:
        """Polynomials of the section."""
        if self.kind == "rectangle":
            return rectangle(thin=(self.thickness or 0) <= (self.width or 0))
        if self.kind == "general":
            return general(tuple((y, z) for y, z in self.fibres or [[0.0, 0.0]]))
        return circle() if self.kind == "circle" else tube()


class FrameMaterial(InputTable):
    """Linear elastic, isotropic material; G = E / (2 (1 + nu)) in torsion and shear."""

    youngs_modulus: Positive  # stress
    density: Positive  # mass / length^3
    poisson_ratio: Annotated[float, Field(gt=-1, lt=0.5)] | None = None  # in space, where beams twist, and with shear


class FramePoint(InputTable):
    """A node where joints and loads may grip."""

    node: str


AXES = "xyz"
POLAR = {"length": "length", "angle": "angle"}
"""Numbers of a node at a length and an angle, and what they are, for their units."""


def node_values(nodes: Mapping[str, Sequence[float]], polar: Mapping[str, PolarNode]) -> dict[str, float]:
    """Values of the nodes' parameters: `x_A` of a node with coordinates, `length_B` and `angle_B` of one without."""
    found = {f"{axis}_{name}": value for name, place in nodes.items() for axis, value in zip(AXES, place, strict=False)}
    return found | {f"{key}_{name}": getattr(each, key) for name, each in polar.items() for key in POLAR}


def positions(
    nodes: Mapping[str, Sequence[float]], polar: Mapping[str, PolarNode], design: Mapping[str, complex] | None = None
) -> dict[str, np.ndarray]:
    """Places (d,) of all nodes at a design, by default that of the file, real or complex; those with coordinates first."""
    values = node_values(nodes, polar) if design is None else design
    found = {name: np.array([values[f"{axis}_{name}"] for axis in AXES[: len(place)]]) for name, place in nodes.items()}
    for name in _in_order(polar, found):
        length, angle = values[f"length_{name}"], values[f"angle_{name}"]
        found[name] = found[polar[name].start] + length * np.array([np.cos(angle), np.sin(angle)])
    return {name: found[name] for name in [*nodes, *polar] if name in found}


def hanging_in_the_air(nodes: Collection[str], polar: Mapping[str, PolarNode]) -> list[str]:
    """Names of nodes that do not lead back to one with coordinates."""
    return [name for name in polar if name not in set(_in_order(polar, nodes))]


def _in_order(polar: Mapping[str, PolarNode], known: Collection[str]) -> Iterator[str]:
    """Names of nodes, each behind that of the node that it starts from."""
    placed, waiting = set(known), dict(polar)
    while ready := [name for name, each in waiting.items() if each.start in placed]:
        placed.update(ready)
        yield from ready
        waiting = {name: each for name, each in waiting.items() if name not in placed}


SAME_LINE_DISTANCE = 1e-4
"""Distance, in lengths of the shorter beam, below which two beams are on one line; coordinates are typed with four digits or more."""
TOUCHING_DISTANCE = 1e-3
"""Distance, in lengths of a beam, below which a node or another beam touches it: less than any beam is thick."""
MOST_NAMED_PAIRS = 3
"""Number of similar places that are named; the others are counted."""


class MemberLines(NamedTuple):
    """Middle lines of all beams."""

    beams: Sequence[BeamTable]
    nodes: Mapping[str, np.ndarray]  # name -> place (d,)
    start: np.ndarray  # (n, d)
    along: np.ndarray  # (n, d) from start to end
    length: np.ndarray  # (n,)

    @classmethod
    def of(cls, beams: Sequence[BeamTable], nodes: Mapping[str, np.ndarray]) -> Self:
        """Middle lines of beams between named nodes."""
        start = np.array([nodes[beam.start] for beam in beams])
        along = np.array([nodes[beam.end] for beam in beams]) - start
        return cls(beams, nodes, start, along, np.linalg.norm(along, axis=1))

    def name(self, k: int) -> str:
        """Words for a beam: its key and its nodes."""
        return f"beams.{k} (from {self.beams[k].start} to {self.beams[k].end})"

    def connected(self, k: int, m: int) -> bool:
        """Whether two beams have a node in common."""
        return bool({self.beams[k].start, self.beams[k].end} & {self.beams[m].start, self.beams[m].end})


def doubled(beams: Sequence[BeamTable], nodes: Mapping[str, np.ndarray]) -> Iterator[str]:
    """Complaints about beams that lie on each other, whole or in part."""
    lines = MemberLines.of(beams, nodes)
    for k in range(len(beams)):
        shared = _shared_length(lines, k)
        for m in map(int, np.flatnonzero(shared > TOUCHING_DISTANCE * np.minimum(lines.length[k], lines.length[:k]))):
            yield _twice(lines, k, m, float(shared[m]))


def loose_contacts(beams: Sequence[BeamTable], nodes: Mapping[str, np.ndarray]) -> list[str]:
    """Warnings of contacts without a common node: nodes at one place, nodes on beams, beams that cross."""
    lines = MemberLines.of(beams, nodes)
    found = {
        "nodes are at one place without being connected": (_nodes_at_one_place(lines), "If they are one node, give it one name."),
        "nodes lie on beams without being connected": (
            _nodes_on_beams(lines),
            "If they are joined, let two beams meet at the node.",
        ),
        "beams cross without being connected": (_crossings(lines), "If they are joined, put a node there where all of them end."),
    }
    listed = {what: ([*places], remedy) for what, (places, remedy) in found.items()}
    return [f"{what}: {_listed(places)}. {remedy}" for what, (places, remedy) in listed.items() if places]


def _shared_length(lines: MemberLines, k: int) -> np.ndarray:
    """Length (k,) on which each of the beams before it lies on beam k; zero unless they are on one line."""
    length = lines.length[k]
    direction = lines.along[k] / length
    ends = np.stack([lines.start[:k], lines.start[:k] + lines.along[:k]]) - lines.start[k]
    places = ends @ direction
    off = ends - places[..., None] * direction
    low, high = np.maximum(places.min(axis=0), 0.0), np.minimum(places.max(axis=0), length)
    extent = np.where(places[1] == places[0], 1.0, places[1] - places[0])
    parts = [(place - places[0]) / extent for place in (low, high)]
    distances = [np.linalg.norm(off[0] + part[:, None] * (off[1] - off[0]), axis=1) for part in parts]
    on_one_line = np.maximum(*distances) <= SAME_LINE_DISTANCE * np.minimum(length, lines.length[:k])
    return np.where(on_one_line, high - low, 0.0)


def _twice(lines: MemberLines, k: int, m: int, shared: float) -> str:
    """Complaint about two beams that lie on each other."""
    one, two = lines.beams[k], lines.beams[m]
    if {one.start, one.end} == {two.start, two.end}:
        return (
            f"beams.{k}: between {one.start} and {one.end} there is a beam already, beams.{m}, and both would count in mass and "
            "stiffness; leave one out, and give the other a larger section if the member is stronger"
        )
    return (
        f"beams.{k}: {lines.name(k)} and {lines.name(m)} lie on each other over a length of {shared:g}, where both would count in mass "
        "and stiffness; leave one out, or let each end where the other begins"
    )


def _nodes_at_one_place(lines: MemberLines) -> Iterator[str]:
    """Pairs of nodes that are nearer to each other than any beam is long."""
    names, places = list(lines.nodes), np.array(list(lines.nodes.values()))
    near = TOUCHING_DISTANCE * lines.length.min()
    for k, name in enumerate(names):
        for m in np.flatnonzero(np.linalg.norm(places[:k] - places[k], axis=1) <= near):
            yield f"{names[m]} and {name} at {_told(places[k])}"


def _nodes_on_beams(lines: MemberLines) -> Iterator[str]:
    """Nodes between the ends of beams that they are no ends of."""
    for name, place in lines.nodes.items():
        part = np.sum((place - lines.start) * lines.along, axis=1) / lines.length**2
        off = np.linalg.norm(place - lines.start - part[:, None] * lines.along, axis=1)
        for k in map(int, np.flatnonzero((off <= TOUCHING_DISTANCE * lines.length) & _between_ends(part))):
            if name not in (lines.beams[k].start, lines.beams[k].end):
                yield f"{name} on {lines.name(k)}"


def _crossings(lines: MemberLines) -> Iterator[str]:
    """Pairs of beams whose lines meet between the ends of both."""
    for k in range(len(lines.beams)):
        on_one, on_two, off = _nearest(lines, k)
        near = off <= TOUCHING_DISTANCE * np.minimum(lines.length[k], lines.length[:k])
        for m in map(int, np.flatnonzero(near & _between_ends(on_one) & _between_ends(on_two))):
            if not lines.connected(k, m):
                yield f"{lines.name(m)} and {lines.name(k)} at {_told(lines.start[k] + on_one[m] * lines.along[k])}"


def _nearest(lines: MemberLines, k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nearest points of beam k and each beam before it, as parts of their lengths, and their distance; (k,) each."""
    one, two = lines.along[k], lines.along[:k]
    gap = lines.start[:k] - lines.start[k]
    mixed, squares = two @ one, lines.length[:k] ** 2
    determinant = lines.length[k] ** 2 * squares - mixed**2
    parallel = determinant <= SAME_LINE_DISTANCE**2 * lines.length[k] ** 2 * squares
    safe = np.where(parallel, 1.0, determinant)
    on_one = np.where(parallel, -1.0, (squares * (gap @ one) - mixed * np.sum(gap * two, axis=1)) / safe)
    on_two = (on_one * mixed - np.sum(gap * two, axis=1)) / squares
    off = np.linalg.norm(gap + on_two[:, None] * two - on_one[:, None] * one, axis=1)
    return on_one, on_two, off


def _between_ends(part: np.ndarray) -> np.ndarray:
    return (part > TOUCHING_DISTANCE) & (part < 1 - TOUCHING_DISTANCE)


def _listed(found: Sequence[str]) -> str:
    more = f", and {len(found) - MOST_NAMED_PAIRS} more" if len(found) > MOST_NAMED_PAIRS else ""
    return ", ".join(found[:MOST_NAMED_PAIRS]) + more


def _told(place: np.ndarray) -> str:
    return f"({', '.join(f'{x:g}' for x in place)})"
