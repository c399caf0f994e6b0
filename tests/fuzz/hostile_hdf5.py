"""Ways to spoil an HDF5 file: what stands in the place of an array, a group or an attribute, and what happens to the bytes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

Spoil = Callable[[h5py.File, str], Any]
TEXT = h5py.string_dtype()


def put(value: Any, **options: Any) -> Spoil:
    """Another array."""
    return lambda file, name: file.create_dataset(name, data=value, **options)


def filled(value: float) -> Spoil:
    """An array of the old shape, full of one number."""
    return lambda file, name: file.create_dataset(name, data=np.full(SHAPES.get(name, ()), value))


def typed(dtype: Any) -> Spoil:
    """Ones of another type in the old shape."""
    return lambda file, name: file.create_dataset(name, data=np.ones(SHAPES.get(name, ()), dtype))


def claimed(shape: tuple[int, ...], **options: Any) -> Spoil:
    """An array that holds nothing of what it claims."""
    return lambda file, name: file.create_dataset(name, shape=shape, dtype=float, **options)


def linked(link: Callable[[str], Any]) -> Spoil:
    """A link in place of what it leads to."""

    def change(file: h5py.File, name: str) -> None:
        file[name] = link(name)

    return change


def to_itself(file: h5py.File, name: str) -> None:
    """A group that contains itself, and the root."""
    group = file.create_group(name)
    group["again"], group["invariants"] = group, file["/"]


def virtual(source: str) -> Spoil:
    """An array that lies in another file, or in itself."""

    def change(file: h5py.File, name: str) -> None:
        layout = h5py.VirtualLayout((3, 3), float)
        layout[:] = h5py.VirtualSource(source, name, (3, 3))
        file.create_virtual_dataset(name, layout)

    return change


def packed_twice(file: h5py.File, name: str) -> None:
    """Two rounds of compression, which together unpack a million times."""
    settings = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    settings.set_chunk((1000, 1000))
    for _ in range(2):
        settings.set_deflate(9)
    file.create_dataset(name, data=np.zeros((1000, 1000)), dcpl=settings)


def many_names(file: h5py.File, name: str) -> None:
    """A group of many groups, some of whose names are no text."""
    group = file.create_group(name)
    for k in range(300):
        group.create_group(f"{k}")
    h5py.h5g.create(group.id, b"\xff\xfe")


RECORD = np.dtype([("a", float), ("b", "S3")])
IN_PLACE_OF_ANYTHING: dict[str, Spoil] = {
    "nothing": lambda *_: None,
    "group": lambda file, name: file.create_group(name),
    "group in itself": to_itself,
    "many names": many_names,
    "type": lambda file, name: file.__setitem__(name, np.dtype("f8")),
    "empty": put(h5py.Empty("f8")),
    "empty text": put(h5py.Empty("S3")),
    "text": put("text"),
    "bytes": put(np.bytes_(b"\xff\xfe")),
    "long text": put("x" * 1_000_000),
    "texts": put(np.array(["a", "b"], object), dtype=TEXT),
    "record": typed(RECORD),
    "opaque": put(np.void(b"abc")),
    "enumeration": typed(h5py.enum_dtype({"a": 0, "b": 1}, "i1")),
    "truth": typed(bool),
    "complex": typed(complex),
    "long double": typed(np.longdouble),
    "half": typed(np.float16),
    "big-endian": typed(">f8"),
    "unsigned": put(np.full((3, 3), 2**64 - 1, np.uint64)),
    "reference": put(np.array([h5py.Reference()] * 2), dtype=h5py.ref_dtype),
    "ragged": put(np.array([np.ones(2), np.ones(3)], object), dtype=h5py.vlen_dtype(float)),
    "no axes": put(1.0),
    "no entries": put(np.zeros((0, 0))),
    "thirty-two axes": put(np.ones((1,) * 32)),
    "nan": filled(np.nan),
    "infinite": filled(np.inf),
    "zero": filled(0.0),
    "minus zero": filled(-0.0),
    "one": filled(1.0),
    "minus one": filled(-1.0),
    "largest": filled(1.7e308),
    "huge": filled(1e155),
    "smallest": filled(5e-324),
    "claims chunks": claimed((10**6, 10**6), chunks=(1000, 1000)),
    "claims one block": claimed((10**12,)),
    "claims what can be": claimed((2000, 2000)),
    "claims a huge chunk": claimed((3, 3), chunks=(20_000, 20_000), maxshape=(None, None)),
    "bomb": put(np.zeros((1500, 1500)), compression="gzip"),
    "packed twice": packed_twice,
    "other packing": put(np.zeros((30, 30)), compression="lzf"),
    "virtual": virtual("other.h5"),
    "virtual circle": virtual("."),
    "outside": claimed((3, 3), external=[("/dev/zero", 0, 72)]),
    "soft circle": linked(lambda name: h5py.SoftLink(f"/{name}")),
    "soft to the root": linked(lambda _: h5py.SoftLink("/")),
    "elsewhere": linked(lambda name: h5py.ExternalLink("good.h5", name)),
    "to itself from outside": linked(lambda name: h5py.ExternalLink("case.h5", name)),
    "to a pipe": linked(lambda name: h5py.ExternalLink("pipe", name)),
}
"""What stands where an array or a group should be."""

ATTRIBUTES: dict[str, Any] = {
    "empty": h5py.Empty("f8"), "array": np.arange(3), "texts": np.array(["a", "b"], object), "bytes": np.bytes_(b"\xff"),
    "long": "x" * 60_000, "record": np.zeros((), RECORD), "truth": True, "complex": 1j, "nan": np.nan, "infinite": np.inf,
    "zero": 0.0, "smallest": 5e-324, "largest": 1.7e308, "negative": -1.5, "whole": 2**63 - 1, "unsigned": np.uint64(2**64 - 1),
    "long double": np.longdouble(1), "word": np.bytes_(b"word"), "words": np.bytes_(b"two\nlines \x1b[31m"),
    "variable": "word",
}  # fmt: skip

SHAPES: dict[str, tuple[int, ...]] = {}
"""Shapes of the arrays of the file at hand."""


def spoilt_objects(good: Path, path: Path, names: list[str]) -> Iterator[str]:
    """Write one spoilt file after the other to `path`, and say what it is."""
    for name in names:
        for kind, spoil in IN_PLACE_OF_ANYTHING.items():
            path.write_bytes(good.read_bytes())
            with h5py.File(path, "a", libver="v110") as file:
                if isinstance(file[name], h5py.Dataset):
                    SHAPES[name] = file[name].shape
                del file[name]
                spoil(file, name)
            yield f"{name}: {kind}"


def spoilt_attributes(good: Path, path: Path, names: list[str]) -> Iterator[str]:
    """The same for attributes, named as owner@attribute."""
    for name in names:
        owner, _, key = name.partition("@")
        for kind, value in [*ATTRIBUTES.items(), ("nothing", None)]:
            path.write_bytes(good.read_bytes())
            with h5py.File(path, "a", libver="v110") as file:
                del file[owner].attrs[key]
                if value is not None:
                    file[owner].attrs[key] = value
            yield f"{name}: {kind}"


def spoilt_bytes(good: Path, path: Path, cuts: int, flips: int, seed: int) -> Iterator[str]:
    """Truncated, extended, and with one to a hundred bits or bytes changed, more often at the beginning."""
    whole, rng = good.read_bytes(), np.random.default_rng(seed)
    for size in np.linspace(0, len(whole) - 1, cuts).astype(int):
        path.write_bytes(whole[:size])
        yield f"cut to {size}"
    for k in range(flips):
        content = bytearray(whole)
        end = len(whole) if k % 2 else min(len(whole), 4000)
        places = rng.integers(0, end, 1 if k % 3 else int(rng.integers(2, 100)))
        for place in places:
            content[place] = content[place] ^ (1 << int(rng.integers(8))) if k % 4 else int(rng.choice([0, 1, 127, 255]))
        path.write_bytes(content)
        yield f"change {k} at {places[:5]}"
