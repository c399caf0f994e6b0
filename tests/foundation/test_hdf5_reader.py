"""The reader of HDF5 against the library: the same content of every file that is taken, and no word of the library for the rest."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.fuzz.good_files import PREPARED
from tests.fuzz.sealed_hdf5 import blocks_of
from toolkit.foundation.errors import ModelFileError
from toolkit.foundation.files.hdf5 import Content, reading
from toolkit.foundation.files.hdf5_source import checksum
from toolkit.reduced_model.file import load, stored_bytes

ROOT = Path(__file__).parents[2]
MODELS = sorted((ROOT / "models").glob("*/*.h5"))
PACKED = {"compression": "gzip", "shuffle": True, "fletcher32": True}


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def damaged(reason: str) -> ModelFileError:
    return ModelFileError(f"damaged: {reason}")


def objects(group: h5py.Group, name: str = "/") -> Iterator[tuple[str, h5py.Group | h5py.Dataset]]:
    """All that is in a file, by the library."""
    yield name, group
    for key, found in group.items():
        if isinstance(found, h5py.Group):
            yield from objects(found, f"{name.rstrip('/')}/{key}")
        else:
            yield f"{name.rstrip('/')}/{key}", found


def compare(path: Path) -> int:
    """Number of objects, all of which are the same by the library and by the program."""
    count = 0
    with h5py.File(path) as file, reading(path, damaged) as content:
        for count, (name, expected) in enumerate(objects(file), 1):  # noqa: B007
            if isinstance(expected, h5py.Group):
                assert content.group(name) == list(expected), name
                values = {key: value.decode() if isinstance(value, bytes) else value for key, value in expected.attrs.items()}
                found = content.attributes(name)
                assert list(found) == list(values), name
                assert found == values, name
            else:
                np.testing.assert_array_equal(content.array(name), expected[()], strict=False, err_msg=name)
                assert content.array(name).shape == expected.shape
                assert content.stored_bytes(name) == expected.id.get_storage_size(), name
    return count


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.parent.name)
def test_shipped_models_are_read_as_by_the_library(path):
    assert compare(path) > 60


@pytest.mark.parametrize("kind", PREPARED)
def test_what_the_program_writes_is_read_as_by_the_library(tmp_path, kind):
    PREPARED[kind](tmp_path)
    assert compare(tmp_path / "good.h5") > 25


@pytest.mark.parametrize("tracked", [True, False], ids=["as made", "by name"])
@pytest.mark.parametrize(
    "count", [3, 9, 400, 6000]
)  # in the header; in one block; in several; in blocks of blocks, and a deeper tree
def test_names_of_groups_of_every_size(tmp_path, count, tracked, rng):
    with h5py.File(tmp_path / "file.h5", "w", libver="v110") as file:
        group = file.create_group("group", track_order=tracked)
        for k in rng.permutation(count):
            group.create_group(f"name {k} " * (1 + k % 5))
    assert compare(tmp_path / "file.h5") == count + 2


@pytest.mark.parametrize("tracked", [True, False], ids=["as made", "by name"])
@pytest.mark.parametrize("count", [3, 9, 800])
def test_attributes_of_every_number_and_size(tmp_path, count, tracked, rng):
    """Those of more than 64 kB lie outside of the blocks of all others."""
    with h5py.File(tmp_path / "file.h5", "w", libver="v110") as file:
        group = file.create_group("group", track_order=tracked)
        for k in rng.permutation(count):
            group.attrs[f"text {k}"] = np.bytes_(b"x" * (1 + 5 * int(k)))
        for kind in ("i1", "u2", ">i4", "i8", "f2", "f4", ">f8"):
            group.attrs[kind] = np.array(97.0).astype(kind)
        group.attrs["huge"], group.attrs["also huge"] = np.bytes_(b"y" * 70_000), np.bytes_(b"z" * 200_000)
    assert compare(tmp_path / "file.h5") == 2


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", ">i2", "u4", "i8", ">i8", "f2", "f4", ">f8", "f8", "S1", "S7"])
@pytest.mark.parametrize("shape", [(1,), (999,), (40, 50), (17, 13, 11)], ids=str)
def test_arrays_of_every_type_shape_and_packing(tmp_path, kind, shape, rng):
    values = (100 * rng.random(shape)).astype(kind)
    thirds = tuple(-(-size // 3) for size in shape)
    with h5py.File(tmp_path / "file.h5", "w", libver="v110") as file:
        file["plain"] = values
        file.create_dataset("packed", data=values, **PACKED)
        file.create_dataset("one piece", data=values, chunks=shape, **PACKED)
        file.create_dataset("pieces", data=values, chunks=thirds)
        file.create_dataset("packed pieces", data=values, chunks=thirds, **PACKED)
        file.create_dataset("checked pieces", data=values, chunks=thirds, fletcher32=True)
    assert compare(tmp_path / "file.h5") == 7


@pytest.mark.parametrize("name", ["noise", "pages", "pages packed", "zeros", "ones", "none", "single", "long text"])
def test_arrays_at_the_edges_of_the_format(tmp_path, name, rng):
    """Noise, which is stored unpacked; lists of pieces with pages; sums of a checksum that are zero by their remainder."""
    contents = {
        "noise": (rng.integers(0, 256, 100_000, "u1"), PACKED),
        "pages": (rng.random((100, 300)), {"chunks": (3, 4)}),
        "pages packed": (rng.random(30_000), {"chunks": (7,), **PACKED}),
        "zeros": (np.zeros((300, 1000)), PACKED),
        "ones": (np.full(100_001, 0xFFFF, "u2"), PACKED),
        "none": (np.zeros((0, 3)), {}),
        "single": (3.5, {}),
        "long text": (np.bytes_(b"z" * 70_000), {}),
    }
    values, options = contents[name]
    with h5py.File(tmp_path / "file.h5", "w", libver="v110") as file:
        file.create_dataset("values", data=values, **options)
    assert compare(tmp_path / "file.h5") == 2


@pytest.mark.parametrize(("text", "value"), [("", 0xDEADBEEF), ("Four score and seven years ago", 0x17770551)])
def test_the_checksum_is_the_published_one(text, value):
    """Values from the source of lookup3 by its author, with a start of zero."""
    assert checksum(text.encode()) == value


@pytest.fixture
def model(tmp_path) -> Path:
    """A small good model."""
    PREPARED["model"](tmp_path)
    return tmp_path / "good.h5"


@pytest.mark.robustness
def test_every_changed_byte_of_a_structure_is_noticed(model):
    """Flips of one bit, at every 97th byte of all structures of the file."""
    good, blocks = model.read_bytes(), [block for block in blocks_of(model.read_bytes()) if block.structure]
    places = sorted({place for block in blocks for place in range(block.place, block.place + block.size)})[::97]
    assert len(places) > 100
    for place in places:
        content = bytearray(good)
        content[place] ^= 1 << place % 8
        model.write_bytes(content)
        with pytest.raises(ModelFileError, match=r"good\.h5"):
            load(model)


def test_the_number_that_ended_the_process_is_refused(model):
    """A tree of 10 records that claims 32 778, with the right checksum: HDF5 2.0 writes them behind its memory."""
    good = model.read_bytes()
    trees = [block for block in blocks_of(good) if good[block.place :].startswith(b"BTHD")]
    assert trees
    for tree in trees:
        own = bytearray(good[tree.place : tree.place + tree.size])
        own[27] = 128
        model.write_bytes(good[: tree.place] + tree.sealed(bytes(own)) + good[tree.place + tree.size :])
        with pytest.raises(ModelFileError, match=r"instead of 327\d\d records.*Build it again"):
            load(model)


def test_reading_does_without_the_library(model):
    code = f"import sys; from toolkit.reduced_model.file import load; load({str(model)!r}); assert 'h5py' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.h5")
    with pytest.raises(ModelFileError, match="not a regular file"), reading(tmp_path / "pipe.h5", damaged):
        pass


def test_groups_in_each_other_are_counted_once(model):
    """Forty groups, each twice in the next one: a million million ways lead to the array."""
    with h5py.File(model, "a", libver="v110") as file:
        below = file["mesh"]
        for k in range(40):
            above = file.create_group(f"level {k}")
            above["one"] = above["two"] = below
            below = above
        file["outline"] = below
    sizes = stored_bytes(model)
    assert sizes["outline"] == sizes["mesh"] > 0


def test_no_more_is_claimed_than_a_file_could_hold(tmp_path):
    """Three hundred names of one array that was packed a thousand times."""
    with h5py.File(tmp_path / "file.h5", "w", libver="v110") as file:
        file.create_dataset("a0", data=np.zeros(10**6), **PACKED)
        for k in range(1, 300):
            file[f"a{k}"] = file["a0"]
    with reading(tmp_path / "file.h5", damaged) as content:
        count = read_until_refused(content)
    assert 0 < count * 8e6 < 1100 * (tmp_path / "file.h5").stat().st_size


def read_until_refused(content: Content) -> int:
    """How many of the arrays can be read."""
    for k in range(300):
        try:
            content.array(f"a{k}")
        except ValueError as error:
            assert "which are not in the file" in str(error)  # noqa: PT017
            return k
    return 300
