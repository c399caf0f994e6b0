"""Reduced models that another program wrote in plain HDF5 are the same models; what is wrong or hostile in them is refused in words."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.fuzz.good_files import SCENE, beam
from tests.reduced_model.test_reduced_model import equal
from toolkit.analyses.sensitivity.preparation import evaluate_responses, prepare, solve
from toolkit.api.describe import PLAIN, describe
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ModelFileError
from toolkit.foundation.files import plain_hdf5
from toolkit.reduced_model.file import described_by, hash_of, is_reduced_model, load, save, stored_bytes

PACKED = {"compression": "gzip", "shuffle": True, "chunks": True}


@pytest.fixture(scope="module")
def own(tmp_path_factory) -> Path:
    """A small model with all kinds of dependences, as this program writes it."""
    path = tmp_path_factory.mktemp("own") / "beam.h5"
    save(beam(), path)
    return path


@pytest.fixture
def in_this_process(monkeypatch) -> None:
    """The library reads files that are good in this process, which is faster."""
    monkeypatch.setattr(plain_hdf5, "_apart", lambda path, head, _: plain_hdf5.answer(path, head))


def text(value: Any) -> Any:
    """Texts as h5py takes them from Python: of variable length."""
    return value.decode() if isinstance(value, bytes) else value


def fixed(value: Any) -> Any:
    """Texts of fixed length."""
    return value


def matlab(value: Any) -> Any:
    """What `h5writeatt` of MATLAB writes: numbers are floating-point ones, and texts of fixed length."""
    return value if isinstance(value, bytes) else np.asarray(value, float)


def single(value: Any) -> Any:
    """A list of one number or text."""
    return np.array([text(value)], object if isinstance(value, bytes) else None)


def rewritten(source: Path, target: Path, options: dict[str, Any] | None = None) -> Path:
    """The same content as a simple script writes it."""
    own = {"attribute": text, "array": np.asarray, "packing": {}, "growing": False} | (options or {})
    form = {key: own.pop(key) for key in ("libver", "track_order") if key in own}

    def copy(name: str, each: h5py.Group | h5py.Dataset) -> None:
        if isinstance(each, h5py.Dataset):
            packing = own["packing"] | ({"chunks": True, "maxshape": (None,) * each.ndim} if own["growing"] else {})
            file.create_dataset(name, data=own["array"](each[()]), **(packing if each.ndim else {}))
            return
        group = file.require_group(name) if name == "/" else file.create_group(name, track_order=form.get("track_order"))
        for key, value in each.attrs.items():
            group.attrs[key] = own["attribute"](value)

    with h5py.File(source) as good, h5py.File(target, "w", **form) as file:
        copy("/", good)
        good.visititems(copy)
    return target


WRITINGS: dict[str, dict[str, Any]] = {
    "h5py as it is by default": {},
    "oldest form, fixed texts": {"libver": "earliest", "attribute": fixed},
    "newest form": {"libver": "latest"},
    "packed in pieces": {"packing": PACKED},
    "newest form, packed by lzf": {"packing": {"compression": "lzf"}, "libver": "latest"},
    "newest form, growing arrays": {"growing": True, "libver": "latest"},
    "big-endian numbers": {"array": lambda value: value.astype(value.dtype.newbyteorder(">"))},
    "attributes of length one": {"attribute": single},
    "MATLAB": {"attribute": matlab, "array": lambda value: np.asarray(value, float)},
}


@pytest.mark.parametrize("writing", WRITINGS)
@pytest.mark.usefixtures("in_this_process")
def test_a_model_of_another_program_is_the_same_model(own, tmp_path, writing):
    path = rewritten(own, tmp_path / "beam.h5", WRITINGS[writing])
    model, expected = load(path), load(own)
    assert equal(model, expected)
    assert (model.plain, expected.plain) == (True, False)
    assert describe(model) == describe(expected) | {"form": PLAIN}


@pytest.mark.usefixtures("in_this_process")
def test_every_question_about_a_model_of_another_program_is_answered(own, tmp_path):
    path = rewritten(own, tmp_path / "beam.h5")
    assert is_reduced_model(path)
    assert hash_of(path) == hash_of(own)
    assert described_by(path) == described_by(own)
    sizes = stored_bytes(path)
    assert set(sizes) == set(stored_bytes(own))
    assert sizes["invariants"] == sum(8 * getattr(load(own).invariants, f.name).size for f in fields(load(own).invariants))


def test_newest_form_with_fixed_texts_is_read_without_the_library(own, tmp_path, monkeypatch):
    monkeypatch.setattr(plain_hdf5, "CHILD", "raise SystemExit(1)")
    path = rewritten(own, tmp_path / "beam.h5", {"libver": "latest", "attribute": fixed})
    assert equal(load(path), load(own))


def test_a_scene_runs_with_a_model_of_another_program(own, tmp_path):
    """To the last digit as with the model that it was written from."""
    (tmp_path / "scene.toml").write_text(SCENE.replace("MODEL", "case.h5"))
    values = []
    for write in (rewritten, shutil.copy):
        write(own, tmp_path / "case.h5")
        values.append(evaluate_responses(solve(prepare(read_scene(tmp_path / "scene.toml"), []), "static")))
    assert values[0].keys() == {"stress", "shape"}
    assert values[0] == values[1]


# --- the order of the parameters ---------------------------------------------------------------------------------------


def without_list(path: Path) -> Path:
    with h5py.File(path, "a") as file:
        del file.attrs["parameters"]
    return path


@pytest.mark.usefixtures("in_this_process")
def test_a_model_without_an_order_of_its_parameters_is_refused(own, tmp_path):
    """Polynomials and derivatives count them: in the order of their names the numbers would be those of other parameters."""
    path = without_list(rewritten(own, tmp_path / "beam.h5"))
    with pytest.raises(
        ModelFileError, match="not say in which order its parameters count: write their names, one a line, as the"
    ):
        load(path)
    kept = without_list(rewritten(own, tmp_path / "kept.h5", {"track_order": True}))
    assert equal(load(kept), load(own))


@pytest.mark.usefixtures("in_this_process")
@pytest.mark.parametrize("names", ["youngs_modulus", "", "a\nb", "thickness\n" * 6])
def test_a_list_of_other_parameters_is_refused(own, tmp_path, names):
    path = rewritten(own, tmp_path / "beam.h5")
    with h5py.File(path, "a") as file:
        file.attrs["parameters"] = names
    with pytest.raises(ModelFileError, match="its list of parameters and nominal/ differ by "):
        load(path)


# --- hostile files -----------------------------------------------------------------------------------------------------


def to_itself(file: h5py.File) -> None:
    file["affine/again"] = file["affine"]


def elsewhere(file: h5py.File) -> None:
    del file["mesh/nodes"]
    file.create_dataset("mesh/nodes", (3, 2), float, external=[("/etc/passwd", 0, 48)])


def virtual(file: h5py.File) -> None:
    del file["mesh/nodes"]
    layout = h5py.VirtualLayout((3, 2), float)
    layout[:] = h5py.VirtualSource("own.h5", "mesh/nodes", (3, 2))
    file.create_virtual_dataset("mesh/nodes", layout)


def replaced(name: str, value: Any, **options: Any) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file[name]
        file.create_dataset(name, data=value, **options)

    return change


def claimed(file: h5py.File) -> None:
    del file["mesh/nodes"]
    file.create_dataset("mesh/nodes", (10**9, 2), float, chunks=(10**4, 2))


def attributed(name: str, value: Any) -> Callable[[h5py.File], None]:
    return lambda file: file["nominal"].attrs.__setitem__(name, value)


HOSTILE: dict[str, tuple[Callable[[h5py.File], Any], str]] = {
    "group in itself": (to_itself, "lie deeper in each other than 8 times, or lead in circles"),
    "numbers in another file": (elsewhere, "an array of it lies in other files"),
    "virtual array": (virtual, "an array of it lies in other files"),
    "claims": (claimed, "it claims more than it can hold"),
    "records": (replaced("mesh/nodes", np.zeros(3, [("secret", "f8")])), "holds neither whole nor floating-point numbers"),
    "complex": (replaced("mesh/nodes", np.zeros((3, 2), complex)), "holds neither whole nor floating-point numbers"),
    "empty": (replaced("mesh/nodes", h5py.Empty("f8")), "an array of it has no shape"),
    "halves of elements": (replaced("mesh/connectivity", np.full((2, 2), 0.5)), "mesh/connectivity holds numbers that are no whole"),
    "texts": (replaced("mesh/nodes", ["secret"] * 3), "mesh/nodes holds values that are not finite numbers"),
    "list of values": (attributed("thickness", [0.1, 0.2]), "an attribute of one of its groups is neither a number nor a text"),
    "no value": (attributed("thickness", h5py.Empty("f8")), "an attribute of one of its groups is neither a number nor a text"),
    "lacking": (lambda file: file.__delitem__("invariants/mass"), "it lacks invariants/mass"),
    "link": (lambda file: (file.__delitem__("mesh"), file.__setitem__("mesh", h5py.ExternalLink("own.h5", "mesh"))), "lacks mesh|None"),
}  # fmt: skip


@pytest.mark.parametrize("case", HOSTILE)
@pytest.mark.usefixtures("in_this_process")
def test_what_is_wrong_with_a_model_of_another_program_is_said(own, tmp_path, case):
    change, message = HOSTILE[case]
    path = rewritten(own, tmp_path / "beam.h5")
    with h5py.File(path, "a") as file:
        change(file)
    if case == "link":
        assert load(path).mesh is None
        return
    with pytest.raises(ModelFileError, match=message) as refused:
        load(path)
    assert "secret" not in str(refused.value)


@pytest.mark.parametrize("part", [0.02, 0.7])
def test_a_truncated_file_of_another_program_is_refused(own, tmp_path, part):
    path = rewritten(own, tmp_path / "beam.h5")
    path.write_bytes(path.read_bytes()[: int(part * path.stat().st_size)])
    with pytest.raises(
        ModelFileError, match=r"it is HDF5 of another program, and the library cannot read it either.*Build it again"
    ):
        load(path)
    assert not is_reduced_model(path)


CHILDREN = {
    "crash": ("import os; os.abort()", "the library cannot read it either"),
    "memory": ("raise SystemExit(4)", "it claims more than it can hold"),
    "nonsense": ("print('nonsense')", "it is no HDF5 file|a structure ends too early"),
    "hang": ("import time; time.sleep(60)", "the library comes to no end with it"),
}


@pytest.mark.parametrize("case", CHILDREN)
def test_whatever_happens_to_the_process_of_the_library_is_told_in_words(own, tmp_path, case, monkeypatch):
    code, message = CHILDREN[case]
    monkeypatch.setattr(plain_hdf5, "CHILD", code)
    monkeypatch.setattr(plain_hdf5, "PATIENCE", 0.02 if case == "hang" else 3)
    path = rewritten(own, tmp_path / "beam.h5")
    with pytest.raises(ModelFileError, match=message):
        load(path)


@pytest.mark.robustness
def test_files_with_random_bytes_changed_are_refused_or_models(own, tmp_path, rng):
    """In this process, which a crash would end: the reader of the library is never called here."""
    good = rewritten(own, tmp_path / "beam.h5").read_bytes()
    outcomes = []
    for k in range(10):
        content = bytearray(good)
        for place in rng.integers(0, len(good), 20):
            content[place] ^= 1 << int(rng.integers(8))
        (tmp_path / f"{k}.h5").write_bytes(bytes(content))
        try:
            outcomes.append(load(tmp_path / f"{k}.h5").dimension in (2, 3))
        except ModelFileError as error:
            outcomes.append("ffrf-preprocess" in str(error))
    assert all(outcomes)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)
