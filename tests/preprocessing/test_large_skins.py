"""Skins with hundreds of elements: what is stored, and what it costs, grows with their number, and no number changes by the way."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import ffrf
from preprocessing import build
from preprocessing.builders.build_model import read_recipe
from toolkit.analyses.sensitivity.preparation import prepare
from toolkit.foundation.errors import InputError, ModelFileError
from toolkit.reduced_model import dependence
from toolkit.reduced_model.check import positive_definite
from toolkit.reduced_model.dependence import is_thin, places, sparing
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load, save
from toolkit.reduced_model.shapes import entry_factors, entry_scales
from toolkit.responses.stress import products

MODELS = Path(__file__).parents[2] / "models"
WING = MODELS / "morphing_wing"
ROUND_OFF = 1e-13
"""Relative: sums of the same numbers in another order."""


def written(folder: Path, elements: int, more: str = "", nodes: tuple[int, ...] | None = None) -> Path:
    """A wing's skin.toml with as many elements, and its three interface points at nodes."""
    for name in ("high_speed.dat", "low_speed.dat", "scene.toml"):
        (folder / name).write_bytes((WING / name).read_bytes())
    text = (WING / "skin.toml").read_text().replace("elements = 30", f"elements = {elements}")
    for node, place in zip((10, 25, 30), nodes or (elements // 3, elements * 5 // 6, elements), strict=True):
        text = text.replace(f"node = {node} ", f"node = {place} ")
    (folder / "skin.toml").write_text(text + more)
    return folder / "skin.toml"


@pytest.fixture
def skin(tmp_path):
    return partial(written, tmp_path)


@pytest.fixture(scope="module")
def fine(tmp_path_factory):
    """Skins of 300 and of 600 elements: their files -> their models, which are saved beside them too."""
    paths = [written(tmp_path_factory.mktemp("fine"), elements) for elements in (300, 600)]
    models = {path: build(path) for path in paths}
    for path, model in models.items():
        save(model, path.with_suffix(".h5"))
    return models


@pytest.fixture
def every_array_is_thin(monkeypatch):
    """The paths of large arrays, for small ones."""
    monkeypatch.setattr(dependence, "SEARCHED_ARRAY_SIZE", 1)
    monkeypatch.setattr(dependence, "SPARSE_PART", 1.1)
    monkeypatch.setattr("toolkit.responses.stress.SEARCHED_ARRAY_SIZE", 1)


def stored(model) -> int:
    """Numbers that are not zero in the invariants, their polynomials and derivatives."""
    arrays = [np.count_nonzero(getattr(model.invariants, f.name)) for f in fields(model.invariants)]
    return sum(arrays) + sum(len(each.value) for group in (model.affine, model.derivatives) for each in group.values())


def test_what_is_stored_of_600_elements_grows_with_their_number(fine):
    """Counted, not timed. Every element adds as many entries; more than their share would be a table with the square of their number."""
    assert [model.n_f for model in fine.values()] == [3 * 300, 3 * 600]
    found = [(stored(model), path.with_suffix(".h5").stat().st_size) for path, model in fine.items()]
    (entries, size), (twice, twice_the_size) = found
    assert twice == pytest.approx(2 * entries, rel=0.01)
    assert twice_the_size < 2.2 * size


def test_the_motion_of_600_elements_is_that_of_300(fine):
    """Both are finer than the contour's file, and the mesh of the reference wing is 3 % off: the largest stress is in an element's end."""
    stress = []
    for path in fine:
        scene = ffrf.read_scene(path.with_name("scene.toml"))
        run = ffrf.compile(scene, variables=["t_w", "E"]).simulate(gradients=True)
        stress.append((run.values["max_stress"], run.gradients["max_stress"]["t_w"]))
    np.testing.assert_allclose(stress[0], stress[1], rtol=1e-3)


@pytest.mark.parametrize("nodes", [(10, 25, 30), None], ids=["joints at one end", "joints all along"])
def test_the_work_of_a_step_grows_with_the_elements(skin, nodes):
    """Counted: entries of the factors, their updates, strains. Each element adds as many, also those of a long free end."""
    found = []
    for elements in (60, 120, 240):
        path = skin(elements, nodes=nodes)
        save(build(path), path.with_suffix(".h5"))
        system = prepare(ffrf.read_scene(path.with_name("scene.toml")))
        plan = system.lu_plan
        found.append(np.array([plan.row_start[-1], len(plan.destination), len(system.plan.constant.strains.value)]))
    np.testing.assert_array_equal(found[2] - found[1], 2 * (found[1] - found[0]))


@pytest.mark.parametrize(
    "more", ['\n[basis]\nkind = "craig-bampton"\ncount = 5\n', '\n[basis]\nkind = "full"\nchord = ["C", "G"]\n']
)
def test_a_basis_of_dense_matrices_has_its_old_limit(skin, more):
    with pytest.raises(
        InputError, match="600 are more than 500, the most of a skin in space, on a chord or with fewer coordinates"
    ):
        read_recipe(skin(600, more))


def test_more_elements_than_memory_bears_are_refused(skin):
    with pytest.raises(InputError, match=r"elements.* 2000"):
        read_recipe(skin(2001))


@pytest.mark.usefixtures("every_array_is_thin")
def test_thin_arrays_give_the_same_values_at_every_design():
    model = load(WING / "skin.h5")
    assert is_thin(model.invariants.stiffness)
    for values in ({"thickness": 2.0}, {"thickness": 1.5 + 1e-30j}, {"density": 3e-9, "youngs_modulus": 6e4 + 1e-30j}):
        thin = DesignPoint(model, values)
        for f in fields(model.invariants):
            polynomial, nominal = model.affine.get(f.name), getattr(model.invariants, f.name)
            p = np.array([values.get(name, value) for name, value in model.nominal.items()])
            expected = nominal if polynomial is None else polynomial(p, nominal.size).reshape(nominal.shape)
            size = np.abs(nominal).max()
            np.testing.assert_allclose(np.real(thin.value(f.name)), np.real(expected), rtol=0, atol=ROUND_OFF * size)
            np.testing.assert_allclose(np.imag(thin.value(f.name)), np.imag(expected), rtol=ROUND_OFF, atol=0)


@pytest.mark.usefixtures("every_array_is_thin")
def test_stress_and_its_gradients_are_the_same_by_thin_arrays():
    found = ffrf.compile(ffrf.read_scene(WING / "scene.toml"), variables=["t_w", "E"]).simulate(gradients=True)
    assert found.values["max_stress"] == pytest.approx(
        56.7836, abs=1e-4
    )  # as docs/abilities.md and README.md have it, of dense arrays
    assert found.gradients["max_stress"]["t_w"] == pytest.approx(-4.37781, abs=1e-5)
    assert found.gradients["max_stress"]["E"] == pytest.approx(0.000509498, abs=1e-9)


@pytest.mark.usefixtures("every_array_is_thin")
@pytest.mark.parametrize(
    ("name", "entry", "change", "words"),
    [
        ("inertia", (40, 40), -2.0, "inertia gives an indefinite mass matrix"),
        ("stiffness", (3, 50), 1e-6, "stiffness is not symmetric"),
        ("gyroscopic", (40, 40), 1e-6, "gyroscopic is not antisymmetric"),
        ("stress_operator", (3, 80), 1e-6, "stress_operator.* differs from invariants/stress_operator"),
    ],
)
def test_the_checks_of_a_file_notice_the_same_in_thin_arrays(tmp_path, name, entry, change, words):
    """One entry is wrong by a part of the largest, or in mass by twice its own."""
    model = load(WING / "skin.h5")
    save(model, tmp_path / "same.h5")
    wrong = getattr(model.invariants, name).copy()
    wrong[entry] += change * (
        wrong[entry] if name == "inertia" else np.abs(wrong).max() or np.abs(model.invariants.inertia).max()
    )
    with pytest.raises(ModelFileError, match=words):
        save(replace(model, invariants=replace(model.invariants, **{name: wrong})), tmp_path / "wrong.h5")


@pytest.mark.usefixtures("every_array_is_thin")
def test_definiteness_by_pivots_is_that_by_eigenvalues():
    """Tridiagonal matrices, whose least eigenvalue is known: 2 - 2 cos(pi / (n + 1)) less the shift."""
    n = 50
    least = 2 - 2 * np.cos(np.pi / (n + 1))
    matrix = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    for shift in (0.0, 0.99 * least, 1.01 * least, 1.0):
        assert positive_definite(matrix - shift * np.eye(n)) == (shift < least)
    assert not positive_definite(np.zeros((3, 3)))
    assert not positive_definite(np.array([[0.0, 1.0], [1.0, 0.0]]))


def test_scales_of_entries_are_the_same_of_sparse_matrices():
    inv = load(WING / "skin.h5").invariants
    thin = replace(
        inv, **{name: sparing(getattr(inv, name)) for name in ("inertia", "gyroscopic", "stiffness", "stress_operator")}
    )
    for name, scale in entry_scales(inv).items():
        every = np.arange(scale.size)
        np.testing.assert_array_equal(entry_factors(thin)[name].at(every), scale.ravel())


@pytest.mark.usefixtures("every_array_is_thin")
def test_products_one_by_one_are_those_of_matrices():
    rng = np.random.default_rng(1)
    one, other = rng.normal(size=(7, 5)), rng.normal(size=(7, 4))
    entry = np.array([3, 19, 3, 0])
    np.testing.assert_allclose(products(one, other, entry), (one.T @ other).ravel()[entry], rtol=1e-13)


@pytest.mark.usefixtures("every_array_is_thin")
def test_places_are_those_that_are_not_zero_and_those_that_are_named():
    array = np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 3.0]])
    np.testing.assert_array_equal(places(array, np.array([4, 1])), [1, 4, 5])
