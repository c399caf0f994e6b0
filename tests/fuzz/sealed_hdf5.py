"""HDF5 files that were changed by somebody who knows the format: every checksum is right, so that nothing stops a reader from following."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np

from toolkit.foundation.files.hdf5 import Content
from toolkit.foundation.files.hdf5_objects import File, Group
from toolkit.foundation.files.hdf5_source import Cursor, Source, checksum
from toolkit.foundation.files.hdf5_storage import Array, fletcher32

NUMBERS = (0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 2**31 - 1, 2**32 - 1, 2**48, 2**63 - 1, 2**63, 2**64 - 1)
"""Written over sizes, counts and addresses."""


@dataclass(frozen=True)
class Block:
    """A part of a file with a checksum of its own: of HDF5's structures, or of the numbers of an array."""

    place: int
    size: int
    seal: int  # place of the checksum in the block
    structure: bool

    def sealed(self, content: bytes) -> bytes:
        """The content with the right checksum."""
        head, tail = content[: self.seal], content[self.seal + 4 :]
        value = checksum(head + bytes(4) + tail if tail else head) if self.structure else fletcher32(head)
        return head + value.to_bytes(4, "little") + tail


class _Recorded(Source):
    """Notes every block that is read."""

    def __init__(self, content: bytes) -> None:
        super().__init__(BytesIO(content), len(content))
        self.blocks: list[Block] = []

    def block(self, place: int, count: int, signature: bytes = b"", hole: int | None = None) -> Cursor:
        """Read as ever, and noted."""
        self.blocks.append(Block(place, count, count - 4 if hole is None else hole, True))
        return super().block(place, count, signature, hole)


def blocks_of(content: bytes) -> list[Block]:
    """All blocks of a good file that have a checksum."""
    source = _Recorded(content)
    file = File(source)
    _visit(file, file, source)
    assert all(each.sealed(content[each.place : each.place + each.size]) == content[each.place : each.place + each.size]
               for each in source.blocks)  # fmt: skip
    return source.blocks


def _visit(file: File, group: Group, source: _Recorded) -> None:
    Content(file, source.size).attributes()
    for link in group.links.values():
        found = file.object(link.place or 0)
        if isinstance(found, Group):
            _visit(file, found, source)
        elif isinstance(found, Array) and len(found._pieces) and found._filters.numbers:
            source.blocks += [Block(piece.place, piece.size, piece.size - 4, False) for piece in found._pieces]


def sealed_changes(good: bytes, count: int, seed: int) -> Iterator[bytes]:
    """So many files, each with one to four changes, three of four of them in HDF5's structures."""
    rng, blocks = np.random.default_rng(seed), blocks_of(good)
    structures, numbers = [b for b in blocks if b.structure], [b for b in blocks if not b.structure]
    for _ in range(count):
        content = bytearray(good)
        for _ in range(int(rng.choice([1, 1, 1, 2, 4]))):
            among = structures if rng.random() < 0.75 or not numbers else numbers
            block = among[rng.integers(len(among))]
            own = bytearray(content[block.place : block.place + block.size])
            _change(own, block, rng, len(good), structures)
            content[block.place : block.place + block.size] = block.sealed(bytes(own))
        yield bytes(content)


def _change(own: bytearray, block: Block, rng: np.random.Generator, size: int, structures: list[Block]) -> None:
    """A bit, a byte, a number of two to eight bytes, or an address of something else."""
    place = int(rng.integers(4, max(5, block.size - 4)))
    kind = rng.integers(5)
    if kind == 0:
        own[place] ^= 1 << int(rng.integers(8))
    elif kind == 1:
        own[place] = int(rng.choice([0, 1, 2, 3, 4, 127, 128, 255, int(rng.integers(256))]))
    elif kind == 2:
        width = int(rng.choice([2, 4, 8]))
        number = int(rng.choice(np.array(NUMBERS, np.uint64))) if rng.random() < 0.5 else int(rng.integers(size + 10))
        own[place : place + width] = (number % 2 ** (8 * width)).to_bytes(width, "little")[: max(0, block.size - place)]
    elif kind == 3:
        target = structures[rng.integers(len(structures))].place
        own[place : place + 8] = target.to_bytes(8, "little")[: max(0, block.size - place)]
    else:
        width = int(rng.integers(1, 12))
        own[place : place + width] = own[4 : 4 + width][: max(0, block.size - place)]


def sealed_files(good: Path, path: Path, count: int, seed: int) -> Iterator[str]:
    """Write one changed file after the other to `path`, and say which it is."""
    for k, content in enumerate(sealed_changes(good.read_bytes(), count, seed)):
        path.write_bytes(content)
        yield f"sealed {k} of {seed}"
