"""What fuzzing found, one named test for each kind: every file is read within limits and refused in words."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from preprocessing.airfoil.airfoil_file import read_airfoil
from preprocessing.builders.skin_recipe import SkinRecipe
from tests.fuzz.hostile_hdf5 import IN_PLACE_OF_ANYTHING
from toolkit.description.results_layout import ResultsFileError
from toolkit.files.results_file import load_results
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError, ModelFileError
from toolkit.reduced_model.file import load
from toolkit.studies.study_file import read_study

ROOT = Path(__file__).parents[2]
WING = ROOT / "models" / "morphing_wing"
PENDULUM = ROOT / "models" / "pendulum" / "scene.toml"

TEXTS = {
    "nested lists": ("a = " + "[" * 3000 + "]" * 3000, "nested more than 30 deep"),
    "nested tables": ("a = " + "{b = " * 200 + "1" + "}" * 200, "nested more than 30 deep"),
    "nested headers": ("[" + ".".join("a" * 60) + "]", "nested more than 30 deep"),
    "a key of endless parts": (".".join(["a"] * 40_000) + " = 1", "a key has more than 100 parts"),
    "a quoted key of endless parts": ('"a" . ' * 40_000 + "b = 1", "a key has more than 100 parts"),
    "a number of 5000 digits": ("a = " + "9" * 5000, "4300 digits"),
    "a hexadecimal number of 5000 digits": ("a = 0x" + "f" * 5000, "more than 64 bits"),
}


@pytest.mark.parametrize("read", [read_scene, SkinRecipe.read])
@pytest.mark.parametrize("kind", TEXTS)
def test_toml_that_chokes_its_reader_is_refused(tmp_path, read, kind):
    text, message = TEXTS[kind]
    (tmp_path / "file.toml").write_text(text)
    with pytest.raises(InputError, match=rf"file\.toml' is not readable as TOML: .*{message}.*Fix that line"):
        read(tmp_path / "file.toml")


@pytest.mark.parametrize("read", [read_scene, SkinRecipe.read, read_airfoil])
def test_a_file_of_any_size_is_refused_without_reading_it_all(tmp_path, read):
    with (tmp_path / "large.toml").open("wb") as file:
        file.truncate(10**12)  # a terabyte that takes no place on the disk
    with pytest.raises(InputError, match=r"large\.toml.*has more than 10*00 bytes\. Give"):
        read(tmp_path / "large.toml")


ZERO_BYTES = {
    "bodies.skin.model": (read_scene, WING / "scene.toml", 'model = "skin.h5"', r'model = "skin\u0000.h5"'),
    "solver.start": (read_scene, PENDULUM, "end_time = 10.0", 'end_time = 10.0\nstart = "kept\\u0000.h5"'),
    "scene": (read_study, WING / "study.toml", 'scene = "scene.toml"', r'scene = "scene\u0000.toml"'),
    "sweep.file": (read_study, WING / "study.toml", "[uncertainty]", '[sweep]\nfile = "designs\\u0000.csv"\n\n[uncertainty]'),
}


@pytest.mark.parametrize("key", ZERO_BYTES)
def test_a_file_name_with_a_zero_byte_is_refused_with_its_key(tmp_path, key):
    read, path, before, after = ZERO_BYTES[key]
    text = path.read_text(encoding="utf-8")
    assert before in text
    (tmp_path / "file.toml").write_text(text.replace(before, after, 1), encoding="utf-8")
    with pytest.raises(InputError, match=rf"{key}: a file name cannot hold a zero byte; write the path of the file"):
        read(tmp_path / "file.toml")


@pytest.mark.parametrize("read", [read_scene, SkinRecipe.read])
def test_a_path_with_a_zero_byte_is_no_path(read):
    with pytest.raises(InputError, match=r"cannot be read \(embedded null byte\)"):
        read("a\0b.toml")


CHANGES: dict[str, tuple[dict[str, str], str]] = {
    "a value that is nested without end": ({"points.P.x": "[" * 3000}, "points"),
    "a value of 5000 digits": ({"solver.step": "9" * 5000}, r"solver\.step"),
    "a design that is no table": ({"design": "3", "points.P.x": "1"}, "design"),
    "an entry of the design that is no path": ({"design.m": "3", "m": "1"}, "'m' leads nowhere"),
    "a type that is a table": ({"bodies.bob.type": "{}"}, r"bodies\.bob\.type = \{\} is unknown; available: .*rod"),
    "a path into a list of the solver": ({"solver.step": "[1]", "solver.step.x.y": "1", "solver.step.9.y": "1"}, "leads nowhere"),
    "an index that only looks like a digit": ({"points.P.²": "1"}, "leads nowhere"),
    "an index of 5000 digits": ({"points.P." + "1" * 5000: "1"}, "leads nowhere"),
    "more iterations than a whole number counts": ({"solver.max_iterations": "9223372036854775807"}, r"solver\.max_iterations"),
    "a number whose square overflows": ({"points.P.x": "1e155"}, r"points\.P\.x: 1e\+155 is invalid: .*fix the exponent"),
    "a number whose inverse overflows": ({"solver.step": "1e-320"}, r"solver\.step: .*is invalid"),
    "a whole number beyond 64 bits": ({"points.P.x": "1" + "0" * 30}, r"points\.P\.x"),
}


@pytest.mark.parametrize("kind", CHANGES)
def test_a_change_that_cannot_be_meant_is_refused(kind):
    changes, message = CHANGES[kind]
    with pytest.raises(InputError, match=message) as error:
        read_scene(PENDULUM, changes)
    assert len(str(error.value)) < 10_000  # what is wrong, not all of it


@pytest.mark.parametrize("name", ["a/b", "/", "a\\u0000b", "", "a.b"])
def test_names_that_are_no_part_of_a_path_are_refused(tmp_path, name):
    text = PENDULUM.read_text()
    (tmp_path / "scene.toml").write_text(text.replace("[points]", f'[points]\n"{name}" = [0.0, 0.0]'))
    with pytest.raises(InputError, match="is no legal name: dots and slashes separate the parts of a path"):
        read_scene(tmp_path / "scene.toml")


AIRFOILS = {
    "a count of 5000 digits": (lambda rows: ["t", "9" * 5000 + " Num Pnts", "1 Num Pnts", *rows], "."),
    "a coordinate whose square overflows": (lambda rows: [*rows[:9], "0.5 1e188", *rows[9:]], "beyond 1e[+]20"),
}


@pytest.mark.parametrize("kind", AIRFOILS)
def test_an_airfoil_with_numbers_beyond_reason_is_read_without_them_or_refused(tmp_path, kind):
    change, message = AIRFOILS[kind]
    rows = (WING / "high_speed.dat").read_text().splitlines()[1:]
    (tmp_path / "airfoil.dat").write_text("\n".join(change(rows)))
    if message == ".":
        assert np.isfinite(read_airfoil(tmp_path / "airfoil.dat").points).all()
        return
    with pytest.raises(InputError, match=message):
        read_airfoil(tmp_path / "airfoil.dat")


def test_rows_that_fold_back_at_the_tail_do_not_throw_the_curve_away(tmp_path):
    """The section of the fuzzer: two rows out of order behind 0.98 chord, where the checks of the rows are lenient."""
    lines = (ROOT / "tests" / "data" / "airfoils" / "fx63137.dat").read_text("latin-1").splitlines()
    lines[1:5] = [lines[4], lines[2], lines[3], lines[1]]
    (tmp_path / "airfoil.dat").write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"rows \d+ and \d+ .* out of order or fold back"):
        read_airfoil(tmp_path / "airfoil.dat").thickness  # noqa: B018


@pytest.fixture
def model(tmp_path) -> Path:
    """A copy of the skin, to be spoilt."""
    os.mkfifo(tmp_path / "pipe")
    return Path(shutil.copy(WING / "skin.h5", tmp_path / "case.h5"))


MODELS = {
    "type": "has something else of that name",
    "texts": "instead of numbers",
    "long double": "instead of numbers",
    "soft circle": "it lacks",
    "to a pipe": "it lacks",
    "elsewhere": "it lacks",
    "group in itself": "has something else of that name",
    "virtual": "which are not in the file",
    "outside": "which are not in the file|external",
    "claims chunks": "which are not in the file",
    "claims one block": "which are not in the file",
    "claims a huge chunk": "which are not in the file",
    "packed twice": "packed in a way that this program does not",
    "largest": r"not finite numbers, or are beyond 1e\+60",
    "nan": "not finite",
}


@pytest.mark.parametrize("kind", MODELS)
def test_what_stands_in_place_of_an_array_is_refused_before_it_is_followed_or_unpacked(model, kind):
    with h5py.File(model, "a", libver="v110") as file:
        del file["invariants/stiffness"]
        IN_PLACE_OF_ANYTHING[kind](file, "invariants/stiffness")
    with pytest.raises(
        ModelFileError, match=rf"(?s)case\.h5'.*invariants/stiffness.*({MODELS[kind]})|({MODELS[kind]}).*Build it again"
    ):
        load(model)


def test_one_packed_array_under_many_names_is_not_unpacked_many_times(model):
    """Each alone could be in the file, all together cannot."""
    with h5py.File(model, "a", libver="v110") as file:
        file["affine/inertia"].create_dataset("packed", data=np.zeros((2500, 2500)), compression="gzip")
        for item in ("inertia", "stiffness", "damping", "gyroscopic"):
            for name in ("term", "entry", "value"):
                del file[f"affine/{item}/{name}"]
                file[f"affine/{item}/{name}"] = file["affine/inertia/packed"]
    with pytest.raises(ModelFileError, match="which are not in the file"):
        load(model)


ATTRIBUTES: dict[str, tuple[str, str, Any, str]] = {
    "a parameter whose inverse overflows": ("nominal", "thickness", 5e-324, "nominal/thickness is 5e-324 instead of"),
    "a number for a text": ("/", "basis", np.nan, "basis is nan instead of a text"),
    "a text that is none": ("/", "basis", np.bytes_(b"\xff"), "damaged or incomplete"),
    "many texts for one": ("/", "units", np.array(["m-kg-s"] * 3, object), "neither a number nor a text"),
    "a text of variable length that is no unit": ("/", "units", "inch", "units is 'inch' instead of one of"),
    "a number for a unit": ("nominal_units", "thickness", 1.0, "nominal_units/thickness is 1.0 instead of a text"),
}


@pytest.mark.parametrize("kind", ATTRIBUTES)
def test_an_attribute_of_another_kind_is_refused(model, kind):
    group, key, value, message = ATTRIBUTES[kind]
    with h5py.File(model, "a", libver="v110") as file:
        del file[group].attrs[key]
        file[group].attrs[key] = value
    with pytest.raises(ModelFileError, match=message):
        load(model)


@pytest.mark.parametrize(
    ("read", "message"),
    [
        (load, "not a reduced model: its attribute 'schema' is not"),
        (load_results, "format without checksums.*Run the scene again"),
    ],
)
def test_a_file_in_a_format_without_checksums_is_not_opened_in_this_process(model, read, message, monkeypatch):
    """A flipped bit there sent HDF5 round in a circle for ever. Models of other programs are opened in another process, results not."""
    with h5py.File(model, "w", libver="earliest") as file:
        file.attrs["schema"] = "any"
    monkeypatch.setattr(h5py, "File", None)
    with pytest.raises((ModelFileError, ResultsFileError), match=rf"case\.h5.*{message}"):
        read(model)


def test_an_integral_of_a_type_that_is_a_table_is_refused():
    with pytest.raises(InputError, match=r"responses\.energy.*`of` needs a table with a `type`, one of: "):
        read_scene(PENDULUM, {"responses.energy": '{ type = "time-integral", of = { type = {} } }'})


@pytest.mark.parametrize("power", [1e300, 21.0, 0.5])
def test_a_power_that_no_stiffness_has_is_refused(model, power):
    with h5py.File(model, "a", libver="v110") as file:
        exponents = file["affine/stiffness/power"][()].astype(float)
        exponents[0, 0] = power
        del file["affine/stiffness/power"]
        file["affine/stiffness/power"] = exponents
    with pytest.raises(ModelFileError, match="affine/stiffness/power holds"):
        load(model)


def test_a_flipped_bit_of_a_model_is_noticed_wherever_it_matters(model):
    """Whatever is accepted is the model that was written."""
    whole, rng = model.read_bytes(), np.random.default_rng(3)
    original = load(model)
    for place in rng.integers(0, len(whole), 60):
        spoilt = bytearray(whole)
        spoilt[place] ^= 1 << int(rng.integers(8))
        model.write_bytes(spoilt)
        try:
            found = load(model)
        except ModelFileError:
            continue
        for name in ("stiffness", "inertia", "stress_operator"):
            assert np.array_equal(getattr(found.invariants, name), getattr(original.invariants, name))
        assert np.array_equal(found.mesh.recovery, original.mesh.recovery)
