"""The reduced-model file: nothing is lost, nothing is read in vain, and nothing wrong is accepted."""

from __future__ import annotations

import os
from dataclasses import fields, replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from toolkit.foundation.errors import InputError, ModelFileError
from toolkit.foundation.files.hdf5 import Content
from toolkit.reduced_model.dependence import Derivatives
from toolkit.reduced_model.design_point import DesignPoint, rates_at
from toolkit.reduced_model.file import PARTS, load, save
from toolkit.reduced_model.frozen_basis import RICHER_PARTS
from toolkit.reduced_model.model import Invariants, ReducedModel

SKIN = Path(__file__).parents[2] / "models" / "morphing_wing" / "skin.h5"


@pytest.fixture
def path(tmp_path) -> Path:
    """A copy of the skin, to be damaged."""
    save(with_moving_target(load(SKIN)), tmp_path / "skin.h5")
    return tmp_path / "skin.h5"


def with_moving_target(model: ReducedModel) -> ReducedModel:
    """The model with a derivative, for the group of derivatives to hold one."""
    return replace(model, derivatives={"shape.target": Derivatives(np.array([2, 3]), np.array([0, 7]), np.array([0.5, -0.25]))})


@pytest.fixture(scope="module")
def model() -> ReducedModel:
    return load(SKIN)


def rewrite(path: Path, name: str, change) -> None:
    """Replace a dataset by what `change` makes of it."""
    with h5py.File(path, "a", libver="v110") as file:
        value = change(file[name][()])
        del file[name]
        file[name] = value


def equal(one, other) -> bool:
    """Equality through all levels of dataclasses, dictionaries and arrays."""
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    if isinstance(one, dict):
        return list(one) == list(other) and all(equal(one[key], other[key]) for key in one)
    if hasattr(one, "__dataclass_fields__"):
        return all(equal(getattr(one, f.name), getattr(other, f.name)) for f in fields(one) if f.compare)
    return one == other


def test_saving_and_loading_loses_nothing(model, tmp_path):
    save(model, tmp_path / "copy.h5")
    again = load(tmp_path / "copy.h5")
    for item in fields(ReducedModel):
        if item.compare and item.name not in ("inputs", "source"):
            assert equal(getattr(model, item.name), getattr(again, item.name)), item.name
    for name in ("inputs", "source"):  # files by their ways from the model's folder, which is another one
        here, there = ({Path(file).name: text for file, text in getattr(each, name).items()} for each in (model, again))
        assert here == there, name


def test_a_saved_file_depends_on_its_content_alone(model, tmp_path):
    for name in ("one.h5", "two.h5"):
        save(model, tmp_path / name)
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "two.h5").read_bytes()


def test_parts_that_were_not_asked_for_are_none_and_not_read(monkeypatch):
    """Bytes read from datasets: what the equations need is a small part of the file."""
    read: list[tuple[str, int]] = []
    original = Content._read

    def counted(content, name):
        values = original(content, name)
        read.append((name, values.nbytes))
        return values

    monkeypatch.setattr(Content, "_read", counted)
    small = load(SKIN, ())
    lean = sum(size for _, size in read)
    assert {name.split("/")[0] for name, _ in read} == {"invariants"}
    assert all(getattr(small, part) is None for part in PARTS if part != "invariants")
    read.clear()
    assert load(SKIN, ("interfaces",)).mesh is None
    assert {name.split("/")[0] for name, _ in read} == {"invariants", "interfaces"}
    read.clear()
    load(SKIN)
    assert {name.split("/")[0] for name, _ in read} >= set(PARTS) - {
        "derivatives",
        "section_derivatives",
        "outline",
        "interior",
        "spin",
        "left_out_shapes",
        "surface",
        "surface_loads",
        "pieces",
        "piece_loads",
        *RICHER_PARTS,
    }  # a skin is planar and has a mesh, and keeps all coordinates
    assert lean < 0.6 * sum(size for _, size in read)  # polynomials, places and pictures make up the other half


def test_an_interrupted_write_leaves_the_old_file_and_no_rest(model, tmp_path, monkeypatch):
    target = tmp_path / "skin.h5"
    save(model, target)
    before = target.read_bytes()

    def full_disk(_):
        raise OSError("no space left on device")

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(InputError, match="no space left"):
        save(model, target)
    assert target.read_bytes() == before
    assert [item.name for item in tmp_path.iterdir()] == ["skin.h5"]


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ModelFileError, match=r"there is no reduced model .*absent\.h5.*ffrf-preprocess"):
        load(tmp_path / "absent.h5")


def test_a_folder_or_a_text_is_no_model(tmp_path):
    (tmp_path / "text.h5").write_text("x, y\n1, 2\n")
    with pytest.raises(
        ModelFileError, match=r"text\.h5' is not an HDF5 file and so not a reduced model\. Give a file written by"
    ):
        load(tmp_path / "text.h5")
    with pytest.raises(
        ModelFileError, match=r"' cannot be read \(it is a folder, not a regular file\)\. Give a reduced model, a file written by"
    ):
        load(tmp_path)


@pytest.mark.parametrize("part", [0.01, 0.5, 0.9, 0.999])
def test_a_truncated_file_is_damaged(path, part):
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(
        ModelFileError, match=r"skin\.h5' cannot be read as a reduced model: it is damaged or incomplete .*truncated.* Build it"
    ):
        load(path)


def test_a_file_with_flipped_bytes_raises_no_foreign_error(path):
    """Anything but a model or a ModelFileError would leave a user alone with the error of a library."""
    content, rng = path.read_bytes(), np.random.default_rng(5)
    for _ in range(40):
        damaged = bytearray(content)
        for place in rng.integers(0, len(content), 20):
            damaged[place] ^= 0xFF
        path.write_bytes(bytes(damaged))
        try:
            load(path)
        except ModelFileError as error:
            assert "skin.h5" in str(error)  # noqa: PT017 (a model that survives is as welcome)


def test_a_foreign_hdf5_file_is_recognised(tmp_path):
    with h5py.File(tmp_path / "other.h5", "w", libver="v110") as file:
        file["data"] = np.arange(3)
    with pytest.raises(
        ModelFileError,
        match=r"other\.h5' is an HDF5 file but not a reduced model: its attribute 'schema' is not 'ffrf-reduced-model'",
    ):
        load(tmp_path / "other.h5")


def test_another_schema_version_names_both(path):
    with h5py.File(path, "a", libver="v110") as file:
        file.attrs["schema_version"] = 99
    with pytest.raises(ModelFileError, match=r"schema version 99, this program reads version 3"):
        load(path)


@pytest.mark.parametrize(
    "name", ["invariants", "invariants/mass", "interfaces/C/position", "stress/fibre", "affine/inertia/power"]
)
def test_a_missing_group_or_dataset_is_named(path, name):
    with h5py.File(path, "a", libver="v110") as file:
        del file[name]
    with pytest.raises(ModelFileError, match=rf"{name.split('/')[-1]}.*Build it again"):
        load(path)


@pytest.mark.parametrize("name", ["nominal", "nominal_units", "writers"])
def test_a_missing_table_of_attributes_is_named(path, name):
    with h5py.File(path, "a", libver="v110") as file:
        del file[name]
    with pytest.raises(ModelFileError, match=rf"{name}.*Build it again"):
        load(path)


@pytest.mark.parametrize("name", ["dimension", "units", "reference_condition", "basis", "input_hash"])
def test_a_missing_attribute_is_named(path, name):
    with h5py.File(path, "a", libver="v110") as file:
        del file.attrs[name]
    with pytest.raises(ModelFileError, match=rf"{name}"):
        load(path)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["invariants/stiffness", "interfaces/E/rotation", "shape/target", "mesh/nodes"])
def test_values_that_are_not_finite_are_refused(path, name, value):
    with h5py.File(path, "a", libver="v110") as file:
        file[name][(0,) * file[name].ndim] = value
    with pytest.raises(ModelFileError, match=rf"{name} holds values that are not finite"):
        load(path)


def with_invariant(model: ReducedModel, **changes) -> ReducedModel:
    return replace(model, invariants=replace(model.invariants, **changes))


@pytest.mark.parametrize(
    ("name", "word"), [("inertia", "not symmetric"), ("gyroscopic", "not antisymmetric"), ("stiffness", "not symmetric")]
)
def test_asymmetric_matrices_are_refused(model, tmp_path, name, word):
    matrix = getattr(model.invariants, name).copy()
    matrix[3, 4] += 1e-3 * np.abs(matrix).max()
    with pytest.raises(ModelFileError, match=rf"invariants/{name} is {word}"):
        save(with_invariant(model, **{name: matrix}), tmp_path / "wrong.h5")
    assert not list(tmp_path.iterdir())


def test_an_indefinite_mass_is_refused_on_loading_too(model, path):
    with h5py.File(path, "a", libver="v110") as file:
        inertia = file["invariants/inertia"][()]
        inertia[5, 5] *= -1
        file["invariants/inertia"][...] = inertia
    with pytest.raises(ModelFileError, match=r"indefinite mass matrix: the basis duplicates a rigid motion"):
        load(path)


def test_a_basis_that_contains_a_rigid_motion_is_refused(model, tmp_path):
    """An elastic coordinate that translates the whole body along x duplicates the frame."""
    inv = model.invariants
    first, inertia, gyroscopic = inv.first_moment.copy(), inv.inertia.copy(), inv.gyroscopic.copy()
    first[:, 1] = [inv.mass, 0]
    inertia[1], gyroscopic[1] = inv.first_moment[0], inv.first_moment[1]
    inertia[:, 1] = inertia[1]
    gyroscopic[:, 1] = -gyroscopic[1]
    inertia[1, 1], gyroscopic[1, 1] = inv.mass, 0
    with pytest.raises(ModelFileError, match="duplicates a rigid motion"):
        save(with_invariant(model, first_moment=first, inertia=inertia, gyroscopic=gyroscopic), tmp_path / "wrong.h5")


@pytest.mark.parametrize("name", [f.name for f in fields(Invariants)])
def test_wrong_shapes_are_refused(model, tmp_path, name):
    wrong = np.concatenate([np.atleast_1d(getattr(model.invariants, name))] * 2, axis=-1)
    with pytest.raises(ModelFileError, match=r"invariants/\w+ has shape"):
        save(with_invariant(model, **{name: wrong}), tmp_path / "wrong.h5")


def grown(array: np.ndarray) -> np.ndarray:
    """The array with its last row along the last axis twice."""
    return np.concatenate([array, array[..., -1:]], axis=-1)


SHAPED = ["affine/stiffness/value", "affine/mass/power", "derivatives/shape.target/value", "interfaces/C/position",
          "interfaces/E/rotation", "interfaces/G/arc_length_range", "stress/end", "shape/position", "shape/target",
          "shape/arc_length", "mesh/nodes", "mesh/connectivity", "mesh/recovery", "mesh/outline", "mesh/target_outline"]  # fmt: skip


@pytest.mark.parametrize("name", SHAPED)
def test_a_wrong_shape_in_any_part_names_the_dataset(path, name):
    rewrite(path, name, grown)
    with pytest.raises(ModelFileError, match=rf"skin\.h5': {name} has shape \(.*\) instead of \(.*Build it again"):
        load(path)


@pytest.mark.parametrize(("name", "shape"), [
    ("derivatives/shape.target/value", (20, 20)), ("interfaces/C/position", (1, 2, 45)), ("invariants/stiffness", ()),
    ("mesh/recovery", (90, 91)), ("affine/stiffness/value", (2,)), ("affine/stiffness/power", (2, 5)),
])  # fmt: skip
def test_a_dataset_of_another_size_or_rank_is_named(path, name, shape):
    rewrite(path, name, lambda _: np.ones(shape))
    with pytest.raises(ModelFileError, match=rf"skin\.h5': {name} has shape .* instead of \("):
        load(path)


WRONG_NUMBERS = {
    "affine/stiffness/power": (lambda e: e + 0.5, "affine/stiffness/power holds numbers of powers that do not exist"),
    "affine/stiffness/factor": (lambda f: f + 9, "affine/stiffness/factor holds numbers of parameters that do not exist"),
    "affine/stiffness/term": (lambda k: k - 1, "affine/stiffness/term holds numbers of terms that do not exist"),
    "affine/stiffness/entry": (lambda k: k + 5000, "affine/stiffness/entry holds numbers of entries that do not exist"),
    "affine/stiffness/value": (lambda c: 3 * c, "affine/stiffness/value differs from invariants/stiffness at the nominal design"),
    "derivatives/shape.target/parameter": (lambda k: k + 9, "parameter holds numbers of parameters that do not exist"),
    "derivatives/shape.target/entry": (lambda k: k + 900, "entry holds numbers of entries that do not exist"),
    "invariants/stiffness": (lambda k: 3 * k, "differs from invariants/stiffness at the nominal design"),
    "invariants/mass": (lambda m: np.bytes_(b"much"), "invariants/mass holds values that are not finite numbers"),
    "interfaces/C/arc_length": (lambda s: s + 1, r"interfaces/C/arc_length is outside its range \[97"),
    "mesh/connectivity": (lambda c: c + 1, "mesh/connectivity names nodes other than 0 to 30"),
    "stress/element": (lambda e: e + 1, "stress/element names elements other than 0 to 29"),
    "stress/end": (lambda e: e + 1, "stress/end holds numbers other than 0 and 1"),
    "stress/fibre": (lambda f: 2 * f, "stress/fibre holds numbers other than -1 and 1"),
}


@pytest.mark.parametrize("name", WRONG_NUMBERS)
def test_numbers_that_contradict_other_parts_are_refused(path, name):
    change, message = WRONG_NUMBERS[name]
    rewrite(path, name, change)
    with pytest.raises(ModelFileError, match=rf"{message}.*Build it again"):
        load(path)


@pytest.mark.parametrize(("group", "name", "value", "message"), [
    ("/", "dimension", 4, "dimension is 4 instead of 2 or 3"),
    ("/", "units", np.bytes_(b"inch"), "units is 'inch' instead of one of mm-t-s"),
    ("nominal", "thickness", np.nan, "nominal/thickness is nan instead of a number that is zero or from"),
    ("nominal", "thickness", np.bytes_(b"thin"), "nominal/thickness is 'thin' instead of a number that is zero or from"),
    ("nominal", "thickness", 0.0, "affine/mass/value differs from invariants/mass at the nominal design"),
    ("nominal", "depth", 1.0, ".*its list of parameters and nominal/ differ by depth"),
])  # fmt: skip
def test_attributes_that_cannot_be_meant_are_refused(path, group, name, value, message):
    with h5py.File(path, "a", libver="v110") as file:
        file[group].attrs[name] = value
    with pytest.raises(ModelFileError, match=rf"skin\.h5':? ?{message}"):
        load(path)


@pytest.mark.parametrize(("old", "new", "message"), [
    ("derivatives/shape.target", "derivatives/shape.aim", "derivatives/shape.aim is the name of nothing in the file"),
    ("derivatives/shape.target", "derivatives/interfaces.H.position", "derivatives/interfaces.H.position is the name of nothing"),
    ("derivatives/shape.target", "derivatives/weight", "derivatives/weight is the name of nothing in the file"),
    ("affine/mass", "affine/weight", "affine/weight is the name of no invariant; there are stiffness"),
])  # fmt: skip
def test_names_that_mean_nothing_are_refused(path, old, new, message):
    with h5py.File(path, "a", libver="v110") as file:
        file.move(old, new)
        file.attrs["contents"] = np.bytes_(file.attrs["contents"].replace(old.encode(), new.encode()))
    with pytest.raises(ModelFileError, match=message):
        load(path)


@pytest.mark.parametrize("name", ["affine/stiffness", "affine/stress_operator", "derivatives/shape.target", "interfaces/C"])
def test_a_part_that_got_lost_is_not_taken_for_independence(path, name):
    with h5py.File(path, "a", libver="v110") as file:
        del file[name]
    with pytest.raises(ModelFileError, match=rf"its list of contents and its groups differ by {name}"):
        load(path)


def test_a_model_that_cannot_be_read_again_is_not_written(model, tmp_path):
    wrong = replace(model, shape=replace(model.shape, target=np.full_like(model.shape.target, np.inf)))
    with pytest.raises(ModelFileError, match=r"shape/target holds values that are not finite numbers"):
        save(wrong, tmp_path / "wrong.h5")


def test_an_unknown_parameter_lists_those_that_exist(model):
    with pytest.raises(
        InputError,
        match=r"no parameter 'tickness', did you mean 'thickness'; available: youngs_modulus, density, thickness, width",
    ):
        DesignPoint(model, {"tickness": 1.0})


def with_tangents(model: ReducedModel) -> ReducedModel:
    """The same model with derivatives at the nominal design in place of all polynomials."""
    p = np.array(list(model.nominal.values()))
    found = {}
    for item, polynomial in model.affine.items():
        found[item] = polynomial.rates(p)
    return replace(model, affine={}, derivatives=found)


def test_a_parameter_without_polynomial_is_fixed_at_its_nominal_value(model):
    tangents, thickness = with_tangents(model), model.nominal["thickness"]
    step = 1e-30j * thickness
    changed, exact = (DesignPoint(each, {"thickness": thickness + step}).value("stiffness") for each in (tangents, model))
    np.testing.assert_allclose(changed.imag, exact.imag, rtol=1e-12, atol=1e-12 * np.abs(exact.imag).max())
    with pytest.raises(InputError, match=r"'thickness' of reduced model .*skin\.h5.* is fixed at 1\.5.*Rerun .*first-order"):
        DesignPoint(tangents, {"thickness": 1.6}).value("stiffness")


def test_on_request_a_parameter_without_polynomial_follows_its_tangent(model):
    """Mass and axial stiffness are linear in the thickness, bending stiffness is cubic: exact for one, off by second order in the other."""
    errors = {}
    for step in (0.1, 0.05):
        follows = DesignPoint(with_tangents(model), {"thickness": 1.5 + step}, first_order=True)
        assert follows.extrapolated() == ["thickness"]
        exact = DesignPoint(model, {"thickness": 1.5 + step})
        np.testing.assert_allclose(follows.value("mass"), exact.value("mass"), rtol=1e-13)
        errors[step] = np.abs(follows.value("stiffness") - exact.value("stiffness")).max()
    assert errors[0.1] / errors[0.05] == pytest.approx(4, abs=0.1)  # (3 t h^2 + h^3) is 4.07 times larger at twice the step


def test_a_derivative_away_from_the_nominal_design_is_refused(model):
    """Where one parameter has left it, the file does not hold the derivative by another."""
    moved = DesignPoint(with_tangents(model), {"thickness": 1.6, "youngs_modulus": 7e4 + 1e-30j})
    with pytest.raises(InputError, match=r"'thickness' .* is fixed at 1\.5"):
        moved.value("stiffness")
    with pytest.raises(InputError, match=r"'thickness' .* is fixed at 1\.5"):
        rates_at(moved, "stiffness", {"width": 0})


def test_what_does_not_depend_on_the_moved_parameter_is_not_refused(model):
    moved = DesignPoint(with_tangents(model), {"density": 3e-9})
    np.testing.assert_array_equal(moved.value("stiffness"), model.invariants.stiffness)
    np.testing.assert_array_equal(moved.interface("C").position, model.interfaces["C"].position)


@pytest.mark.parametrize("step", [0.1, 1e-30j])
@pytest.mark.parametrize("part", ["affine", "derivatives"])
def test_a_parameter_that_nobody_differentiated_by_is_no_silent_zero(model, part, step):
    with pytest.raises(InputError, match=r"'thickness' has no derivatives in reduced model 'skin\.h5'.*rerun preprocessing"):
        DesignPoint(replace(model, **{part: None}), {"thickness": 1.5 + step}).value("stiffness")


def test_an_interface_point_cannot_leave_its_node(model):
    with pytest.raises(InputError, match=r"arc length .* outside .*off a node"):
        model.interfaces["C"].at(model.interfaces["C"].arc_length + 1.0)


@pytest.mark.parametrize("parameter", ["thickness", "youngs_modulus", "width", "density"])
def test_an_imaginary_step_leaves_the_nominal_body_what_it_is(model, parameter):
    """The polynomials round in another way than the stored matrices. A thin skin makes 1e-9 of a gradient out of that last digit."""
    step = DesignPoint(model, {parameter: model.nominal[parameter] + 1e-30j})
    changed = 0
    for item in fields(model.invariants):
        found, stored = step.value(f"{item.name}"), getattr(model.invariants, item.name)
        np.testing.assert_array_equal(np.real(found), stored, err_msg=item.name)
        changed += bool(np.any(np.imag(found)))
    assert changed
