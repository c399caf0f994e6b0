"""What a deck holds by construction, and how it is compared with what a reader returns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from preprocessing.foreign_files.contents import Elements, MeshContents
from tests.foreign_decks.abaqus.lattice_bodies import Cell, linear

Key = tuple[str, int]
"""Label of an instance, empty without instances and for the assembly, and number of a node."""
Member = int | Key
"""A number in the part or assembly itself, or one in an instance."""
Item = tuple[str, frozenset[Key], frozenset[Key]] | tuple[str, tuple[Key, ...]]
"""A node, a face by its corners and its other nodes, or an element by its nodes in their order."""


class Concentrated(NamedTuple):
    """A mass or rotary inertia on a node."""

    node: Member
    mass: float
    inertia: np.ndarray  # (3, 3)
    carriers: frozenset[Member]
    rigid: bool


@dataclass
class Content:
    """What a part, an instance or the assembly holds by itself."""

    nodes: dict[int, np.ndarray] = field(default_factory=dict)
    elements: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)
    of_masses: dict[int, Member] = field(default_factory=dict)  # number of an element that is a mass -> its node
    sets: dict[str, dict[str, set[Member]]] = field(default_factory=lambda: {"NSET": {}, "ELSET": {}})
    spelled: dict[tuple[str, str], str] = field(default_factory=dict)  # kind and label of a set -> as the deck spells it first
    surfaces: dict[str, list[tuple[str, tuple[Member, ...]]]] = field(default_factory=dict)  # name -> nodes, or faces
    masses: list[Concentrated] = field(default_factory=list)


class Placed(NamedTuple):
    """A part in its place."""

    name: str  # of the instance; empty without instances and for the assembly
    content: Content
    rotation: np.ndarray
    shift: np.ndarray


@dataclass
class Truth:
    """What a reader is to return."""

    placed: list[Placed]  # the deck itself or the assembly first
    left_out: Counter[str]
    remarks: list[str]  # parts of sentences that are to be told
    exact: bool  # whether places are those of the deck, without any transformation
    volume: float | None

    def nodes(self) -> dict[Key, np.ndarray]:
        """Place of every node."""
        return {
            (each.name, label): each.rotation @ place + each.shift
            for each in self.placed
            for label, place in each.content.nodes.items()
        }

    def elements(self) -> Counter[Item]:
        """All elements."""
        return Counter(
            (kind, tuple((each.name, label) for label in nodes))
            for each in self.placed
            for kind, nodes in each.content.elements.values()
        )

    def groups(self) -> Counter[tuple[str, frozenset[Item]]]:
        """Every set and surface under each of its names."""
        found = [
            (which, name, each, items)
            for each in self.placed
            for which, name, items in (*self._sets(each), *self._surfaces(each))
        ]
        times = Counter((which, name.upper()) for which, name, _, _ in found)
        named = Counter[tuple[str, frozenset[Item]]]()
        for which, name, each, items in found:
            alone = times[which, name.upper()] == 1
            if not each.name or alone:
                named[name, items] += 1
            if each.name and (len(self.placed) > 2 or not alone):
                named[f"{each.name}.{name}", items] += 1
        return named

    def _sets(self, each: Placed) -> Iterator[tuple[str, str, frozenset[Item]]]:
        for kind, sets in each.content.sets.items():
            for label, members in sets.items():
                keys = [key_of(each, member) for member in members]
                items = [("vertex", (key,)) for key in keys] if kind == "NSET" else [self._element(key) for key in keys]
                yield kind, each.content.spelled[kind, label], frozenset(item for item in items if item)

    def _surfaces(self, each: Placed) -> Iterator[tuple[str, str, frozenset[Item]]]:
        for name, faces in each.content.surfaces.items():
            yield "SURFACE", name, frozenset(self._face(each, kind, nodes) for kind, nodes in faces)

    def _element(self, key: Key) -> Item | None:
        owner = next(each for each in self.placed if each.name == key[0])
        if key[1] in owner.content.of_masses:
            return "vertex", (key_of(owner, owner.content.of_masses[key[1]]),)
        if key[1] not in owner.content.elements:  # it was left out on purpose
            return None
        kind, nodes = owner.content.elements[key[1]]
        return kind, tuple((owner.name, label) for label in nodes)

    def _face(self, each: Placed, kind: str, nodes: tuple[Member, ...]) -> Item:
        keys = tuple(key_of(each, member) for member in nodes)
        return ("vertex", keys) if kind == "vertex" else face_item(kind, keys)

    def masses(self) -> list[tuple[np.ndarray, float, np.ndarray, frozenset[Key], bool]]:
        """Place, mass, inertia, carriers and whether these are rigid, of all masses."""
        nodes = self.nodes()
        return [
            (
                nodes[key_of(each, mass.node)],
                mass.mass,
                each.rotation @ mass.inertia @ each.rotation.T,
                frozenset(key_of(each, member) for member in mass.carriers),
                mass.rigid,
            )
            for each in self.placed
            for mass in each.content.masses
        ]


def key_of(each: Placed, member: Member) -> Key:
    """The key of a number in a part or assembly."""
    return member if isinstance(member, tuple) else (each.name, member)


def face_item(kind: str, keys: tuple[Key, ...]) -> Item:
    """A face, wherever the numbering of its corners begins."""
    corners = len(linear(Cell(kind, ((0, 0, 0),) * len(keys))).points)
    return kind, frozenset(keys[:corners]), frozenset(keys[corners:])


def difference(truth: Truth, found: MeshContents) -> str:
    """What of a reading is not so, in words; empty of a right one."""
    keys = _keys(truth, found)
    if isinstance(keys, str):
        return keys
    elements = Counter(item for kind, block in found.cells for item in _items(kind, block, keys))
    if elements != truth.elements():
        return f"elements: {elements - truth.elements()} instead of {truth.elements() - elements}"
    surfaces = {name for each in truth.placed for name in _surface_names(each)}
    groups = Counter((name, _content(own, keys, name in surfaces)) for name, own in found.groups)
    if groups != truth.groups():
        return f"groups: {groups - truth.groups()} instead of {truth.groups() - groups}"
    left_out = Counter({each.what: each.number for each in found.left_out})
    if left_out != truth.left_out:
        return f"left out: {left_out} instead of {truth.left_out}"
    if missing := [words for words in truth.remarks if not any(words in each for each in found.remarks)]:
        return f"not told: {missing}"
    return _masses_differ(truth, found, keys)


def _surface_names(each: Placed) -> Iterator[str]:
    for name in each.content.surfaces:
        yield from (name, f"{each.name}.{name}")


def _keys(truth: Truth, found: MeshContents) -> list[Key] | str:
    """The key of every point; by its number where these are told, else by its place."""
    nodes = truth.nodes()
    wanted, places = [*nodes], np.array([*nodes.values()])
    if len(found.points) != len(places):
        return f"{len(found.points)} points instead of {len(places)}"
    if len(found.labels):
        of_label = {key[1]: k for k, key in enumerate(wanted)}
        if len(of_label) != len(wanted) or {*found.labels.tolist()} != {*of_label}:
            return "numbers of nodes"
        order = [of_label[label] for label in found.labels.tolist()]
    else:
        order = KDTree(places).query(found.points)[1].tolist()
        if sorted(order) != [*range(len(places))]:
            return "places of nodes"
    error = np.abs(found.points - places[order]).max(initial=0.0)
    if error > (0.0 if truth.exact else 1e-12 * (10 + np.abs(places).max(initial=0.0))):
        return f"places of nodes, by {error}"
    return [wanted[k] for k in order]


def _items(kind: str, block: np.ndarray, keys: list[Key]) -> Iterator[Item]:
    for row in block.tolist():
        yield kind, tuple(keys[place] for place in row)


def _content(elements: Elements, keys: list[Key], surface: bool) -> frozenset[Item]:
    return frozenset(
        face_item(item[0], item[1]) if surface and item[0] != "vertex" else item
        for kind, block in elements
        for item in _items(kind, block, keys)
    )


def _masses_differ(truth: Truth, found: MeshContents, keys: list[Key]) -> str:
    wanted = truth.masses()
    if len(found.masses) != len(wanted):
        return f"{len(found.masses)} masses instead of {len(wanted)}"
    for each in found.masses:
        xx, yy, zz, xy, xz, yz = each.inertia
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        carriers = frozenset(keys[place] for place in each.carriers.tolist())
        alike = [
            k
            for k, (place, mass, inertia, moved, rigid) in enumerate(wanted)
            if np.allclose(place, each.place, rtol=1e-12, atol=1e-12)
            and mass == each.mass
            and np.allclose(inertia, tensor, rtol=1e-12, atol=1e-12)
            and moved == carriers
            and rigid == each.rigid
        ]
        if not alike:
            return f"a mass that is not there: {each}; {wanted}"
        wanted.pop(alike[0])
    return ""
