"""Puts the chunks of a deck into files: one, or several that include each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from random import Random

from tests.foreign_decks.abaqus.writing import Chunk, as_file

FOLDERS = ("", "", "mesh/", "a b/")


@dataclass
class Folded:
    """The files of a deck."""

    main: str
    contents: dict[str, bytes] = field(default_factory=dict)  # name -> bytes
    marked: dict[str, list[int]] = field(default_factory=dict)  # name -> numbers of marked lines
    folders: tuple[str, ...] = FOLDERS

    def add(self, rng: Random, name: str, lines: Sequence[str], odd: bool) -> None:
        """Add a file."""
        self.contents[name], self.marked[name] = as_file(rng, lines, odd)


def folded(rng: Random, chunks: Sequence[Chunk], odd: float, features: set[str], plain: bool = False) -> Folded:
    """The chunks in files; which data lines and which runs of chunks are in files of their own is chosen at random.

    Plain are those whose names CalculiX 2.20 finds, which takes blanks out of them and *INCLUDE alone.
    """
    found = Folded("body.inp", folders=FOLDERS[:1] if plain else FOLDERS)
    several = rng.random() < 0.4
    blocks = [_with_input(rng, chunk, found, odd, features) if several and not plain else chunk.lines for chunk in chunks]
    if several and len(blocks) > 3:
        blocks = _included(rng, blocks, found, odd, features, 0)
    found.add(rng, found.main, [line for block in blocks for line in block], bool(odd))
    return found


def _with_input(rng: Random, chunk: Chunk, files: Folded, odd: float, features: set[str]) -> list[str]:
    """A chunk whose data lines stand in a file of INPUT, or of an *INCLUDE below its keyword line."""
    way = rng.random()
    if not chunk.movable or len(chunk.data) < 2 or way > 0.5:
        return chunk.lines
    name = f"{rng.choice(files.folders)}data{len(files.contents)}.{rng.choice(['inp', 'txt', 'dat'])}"
    begins = next(k for k, line in enumerate(chunk.data) if not line.lstrip().startswith("**"))
    if way < 0.25:
        files.add(rng, name, chunk.data, bool(odd))
        features.add("INPUT=")
        return [*chunk.head[:-1], f"{chunk.head[-1]}, INPUT={_quoted(rng, name)}"]
    cut = rng.randint(begins + 1, len(chunk.data))
    files.add(rng, name, chunk.data[cut:], bool(odd))
    features.add("*INCLUDE of data lines")
    return [*chunk.head, *chunk.data[:cut], f"*INCLUDE, INPUT={_quoted(rng, name)}"]


def _included(rng: Random, blocks: list[list[str]], files: Folded, odd: float, features: set[str], depth: int) -> list[list[str]]:
    """A run of blocks in a file that is included, of which a run may be in a file again."""
    first = rng.randint(0, len(blocks) - 2)
    after = rng.randint(first + 1, len(blocks))
    inner = blocks[first:after]
    features.add("*INCLUDE nested" if depth else "*INCLUDE")
    if len(inner) > 3 and depth < 3:
        inner = _included(rng, inner, files, odd, features, depth + 1)
    name = f"{rng.choice(files.folders)}part{depth}.inp"
    files.add(rng, name, [line for block in inner for line in block], bool(odd))
    return [*blocks[:first], [f"*Include, input={name if files.folders == FOLDERS[:1] else _quoted(rng, name)}"], *blocks[after:]]


def _quoted(rng: Random, name: str) -> str:
    return f'"{name}"' if rng.random() < 0.3 else name
