"""Files that describe flexible bodies: one base reads, hashes, changes and builds all kinds of them, and a new kind is one class."""

from __future__ import annotations

import subprocess
import sys
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from preprocessing import build
from preprocessing.builders import build_model
from preprocessing.builders.body_recipe import BodyRecipe
from preprocessing.builders.build_model import RECIPES, read_recipe
from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.builders.recipe import WRITER_VERSION, Recipe, Remark, Seal
from preprocessing.builders.tables import BasisTable, InputTable, Positive
from preprocessing.commands.cli import main
from preprocessing.elements.beams import PlanarBeam
from preprocessing.elements.section import Section, distribute
from preprocessing.reduction.discretisation import DesignSpace, Discretisation
from preprocessing.reduction.reduced import reduce
from tests.models.processors import FRAME, MODELS
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.file import SCHEMA_VERSION, load
from toolkit.reduced_model.model import ReducedModel

pytestmark = pytest.mark.usefixtures("read_here")

SKIN, BODY = MODELS / "morphing_wing" / "skin.toml", MODELS / "bracket" / "body.toml"


@pytest.fixture
def files(tmp_path) -> dict[str, Path]:
    """One file of every kind."""
    (tmp_path / "frame.toml").write_text(FRAME)
    return {"skin.toml": SKIN, "body.toml": BODY, "frame.toml": tmp_path / "frame.toml"}


CHANGES: dict[str, tuple[dict[str, float], dict[str, Any]]] = {
    "skin.toml": ({"thickness": 1.6, "interface_points.C.arc_length": 90.0}, {"basis": {"kind": "static"}}),
    "body.toml": ({"density": 2.8e-9, "poisson_ratio": 0.31}, {"basis.count": 2}),
    "frame.toml": ({"x_D": 0.7, "wall_leg": 0.005}, {"basis.kind": "static"}),
}


def test_every_kind_has_a_file_here_and_is_found_by_what_stands_in_it(files):
    assert {kind.name for kind in RECIPES} == set(files)
    for name, path in files.items():
        assert read_recipe(path).name == name


@pytest.mark.parametrize("name", CHANGES)
def test_the_model_bears_the_hash_that_the_recipe_names_ahead_of_it(files, name):
    """Or the command would build a model again and again."""
    recipe, (values, keys) = read_recipe(files[name]), CHANGES[name]
    other = recipe.at(values, keys)
    found = {recipe.hash(), recipe.hash(values), recipe.hash(keys), other.hash()}
    assert len(found) == 4
    assert (
        recipe.hash({**values, **keys})
        == other.hash()
        == other.build().input_hash
        == build(files[name], None, values, keys).input_hash
    )


@pytest.mark.parametrize("name", CHANGES)
def test_one_change_after_another_is_all_of_them_at_once(files, name):
    recipe, (values, keys) = read_recipe(files[name]), CHANGES[name]
    (one, first), *_, (two, second) = values.items()
    found, wanted = recipe.at({one: first}).at({two: second}).at(keys=keys), recipe.at(values, keys)
    assert (found.file, found.hash()) == (wanted.file, wanted.hash())
    assert found.file != recipe.file
    assert set(recipe.changed_tables(recipe.at(keys=keys))) == {"basis"}


def behind_length(content: bytes) -> bytes:
    return f" {len(content)} ".encode() + content


@pytest.mark.parametrize(
    ("name", "word", "of_file", "of_changes"),
    [
        ("skin.toml", b"", behind_length, behind_length),
        ("body.toml", b"body, ", behind_length, bytes),
        ("frame.toml", b"frame, ", bytes, bytes),
    ],
)
def test_models_of_former_versions_are_still_known_by_their_hash(files, name, word, of_file, of_changes):
    """What is hashed is what was hashed when three programs did so."""
    inputs = {
        "skin.toml": [SKIN, SKIN.with_name("high_speed.dat"), SKIN.with_name("low_speed.dat")],
        "body.toml": [BODY, BODY.with_name("bracket.msh")],
        "frame.toml": [files["frame.toml"]],
    }[name]
    values, _ = CHANGES[name]
    content = word + f"schema {SCHEMA_VERSION}, writer {WRITER_VERSION}".encode()
    content += b"".join(of_file(path.read_bytes()) for path in inputs)
    recipe = read_recipe(files[name])
    assert recipe.inputs == inputs
    assert recipe.hash() == sha256(content).hexdigest()
    assert recipe.hash(values) == sha256(content + of_changes(repr(sorted(values.items())).encode())).hexdigest()


@pytest.mark.parametrize("name", CHANGES)
def test_other_values_and_keys_are_refused_by_name(files, name):
    recipe = read_recipe(files[name])
    with pytest.raises(InputError, match=r"has no parameter 'nothing'; there are "):
        recipe.at({"nothing": 1.0})
    with pytest.raises(InputError, match=r"cannot be used:\n  basis\.nothing: unknown key; possible here: kind, "):
        recipe.at(keys={"basis.nothing": 1})


def test_finished_matrices_take_other_keys_and_no_other_values():
    content = {"units": "m-kg-s", "matrices": {"mass": "m.mtx", "stiffness": "k.mtx", "nodes": "n.txt"}, "clamp": {"nodes": [0]}}
    recipe = BodyRecipe.of(content, Path("body.toml"))
    with pytest.raises(
        InputError, match=r"finished matrices hold for the values that they were made with\. Change density in the scene"
    ):
        recipe.at({"density": 2.0})
    assert recipe.at(keys={"basis.kind": "static"}).file.basis.kind == "static"


def test_what_is_up_to_date_is_so_without_the_library_that_would_build_it(tmp_path):
    """Also scikit-fem's second is spared."""
    code = "import sys; sys.modules['skfem'] = None; from preprocessing.commands.cli import main; main()"

    def run(*options: str) -> subprocess.CompletedProcess:
        return subprocess.run(
            [sys.executable, "-c", code, str(BODY), *options], cwd=MODELS.parent, capture_output=True, text=True
        )

    done, lacking = run(), run("--output", str(tmp_path / "body.h5"))
    assert (done.returncode, "is up to date" in done.stdout) == (0, True)
    assert lacking.returncode == 1
    assert "meshed bodies need scikit-fem, which cannot be loaded" in lacking.stderr


class BladeFile(InputTable):
    """A straight beam along x."""

    length: Positive
    thickness: Positive
    basis: BasisTable = BasisTable()


class BladeRecipe(Recipe[BladeFile, DesignSpace]):
    """A new kind of file; four elements."""

    name = "blade.toml"
    schema = BladeFile
    seal = Seal("blade, ", lengths_of_changes=True)
    parts = ("invariants", "derivatives", "affine", "interfaces", "stress")

    @classmethod
    def means(cls, content):
        return "length" in content

    def _named(self) -> list[Path]:
        return []

    def _places(self):
        return {name: (name,) for name in ("length", "thickness")}

    def _designs(self, remark: Remark | None) -> DesignSpace:
        if remark is not None:
            remark("a blade is thin")
        x = np.linspace(0.0, self.file.length, 5)
        parameters = distribute({**STEEL, "thickness": self.file.thickness}, {}, (), 4)
        chain = np.column_stack([np.arange(4), np.arange(1, 5)])
        beams = PlanarBeam(np.column_stack([x, 0 * x]), chain, parameters.patches, rotary_inertia=True)
        elements = Discretisation(beams, {"tip": self.file.length}, x)
        return DesignSpace(parameters.values, parameters.quantities, frozenset(parameters.values), lambda _: elements)

    def _model(self, designs: DesignSpace) -> ReducedModel:
        return reduce(designs, self.file.basis.choice(), 0, "the root").model("m-kg-s")


STEEL = {
    "youngs_modulus": 2.1e11,
    "density": 7850.0,
    "thickness": 0.01,
    "width": 0.1,
    "damping_mass": 0.0,
    "damping_stiffness": 0.0,
}


def test_a_new_kind_is_one_class_and_one_line_in_the_list_of_kinds(tmp_path, monkeypatch, capsys):
    """It is found, built by the command as by the function that builds beams, up to date then, and changed by names and keys."""
    path = tmp_path / "blade.toml"
    path.write_text("length = 2.0\nthickness = 0.02\n")
    with pytest.raises(InputError, match=r"airfoil: this key is missing"):
        read_recipe(path)
    monkeypatch.setattr(build_model, "RECIPES", (BladeRecipe, *RECIPES))
    with pytest.raises(InputError, match=r"Give the path of a skin\.toml, body\.toml, frame\.toml or blade\.toml\."):
        read_recipe(tmp_path / "none.toml")
    monkeypatch.setattr(sys, "argv", ["ffrf-preprocess", str(path)])
    for words in ("blade.h5 written: 12 elastic coordinates, interface points tip.", "is up to date"):
        with pytest.raises(SystemExit, match=r"^0$"):
            main()
        assert words in capsys.readouterr().out
    model = load(tmp_path / "blade.h5")
    nodes = np.column_stack([np.linspace(0, 2, 5), np.zeros(5)])
    expected = polygon_beam(nodes, Section(**{**STEEL, "thickness": 0.02}), {"tip": 2.0})
    for name, array in vars(expected.invariants).items():
        np.testing.assert_array_equal(getattr(model.invariants, name), array)  # the same arithmetic
    assert set(model.inputs) == {"blade.toml"}
    assert model.writers == {"ffrf-toolkit": WRITER_VERSION, "numpy": version("numpy")}
    remarks: list[str] = []
    thick = build(path, remarks.append, {"thickness": 0.03}, {"basis.kind": "eigenmodes", "basis.count": 3})
    assert (thick.nominal["thickness"], thick.n_f, thick.changes, remarks) == (0.03, 3, {"thickness": 0.03}, ["a blade is thin"])
    with pytest.raises(InputError, match=r"blade\.toml' has no parameter 'width'; there are length, thickness\."):
        build(path, values={"width": 1.0})
    with pytest.raises(InputError, match=r"blade\.toml', basis: 40 modes cannot be taken"):
        build(path, keys={"basis": {"kind": "eigenmodes", "count": 40}})
