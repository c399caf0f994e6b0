"""A compiled scene at other numbers is what compiling it anew would have made."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.models.cases import write_models
from tests.models.every_number import SCENES as PLANAR
from tests.models.spatial_cases import write_models as write_spatial_models
from tests.models.spatial_every_number import SCENES as SPATIAL
from toolkit.analyses.sensitivity.preparation import evaluate_with_gradients, prepare, solve
from toolkit.components.bodies.body import MarkerNumbers
from toolkit.components.curves.curve import Curve
from toolkit.components.loads.torque import Torque
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene
from toolkit.system.numbering import number
from toolkit.system.pattern import NewEntryError, renew
from toolkit.system.quantities import GROUPS, STEP, Quantities, derivatives, evaluate_quantities, seen_quantities
from toolkit.system.renewal import renewed
from toolkit.system.system import System

MODELS = sorted((Path(__file__).parents[2] / "models").glob("*/scene.toml"))
EVERY = {
    **{f"planar {name}": make for name, make in PLANAR.items()},
    **{f"spatial {name}": make for name, make in SPATIAL.items()},
}
MOVED = 1e-3
"""Relative change of a number: small enough that every scene still closes."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("models")
    write_models(directory)
    write_spatial_models(directory)
    return directory


def arrays(plan: Any, path: str = "plan") -> Iterator[tuple[str, Any]]:
    """All arrays and numbers of a plan by their place."""
    for name, value in zip(plan._fields, plan, strict=True):
        if hasattr(value, "_fields"):
            yield from arrays(value, f"{path}.{name}")
        elif value is not None:
            yield f"{path}.{name}", value


def kind(value: Any) -> tuple[Any, ...]:
    """What compiled code is made for."""
    flags = value.flags if isinstance(value, np.ndarray) else None
    return (type(value), flags and (value.dtype, value.ndim, str(flags)))


def assert_same(found: System, fresh: System) -> None:
    """Bit by bit: what is made anew is made by the same formulas, and what is kept has not changed."""
    for (place, one), (where, other) in zip(arrays(found.plan), arrays(fresh.plan), strict=True):
        assert (place, kind(one)) == (where, kind(other))  # the compiled loop is handed it without another look
        assert np.array_equal(one, other), place
    assert reached(found) == reached(fresh)  # a renewal evaluates what the first compilation has found to depend on a variable
    assert np.array_equal(found.weights, fresh.weights)
    assert found.design == fresh.design
    assert all(np.array_equal(one, other) for one, other in zip(found.start(), fresh.start(), strict=True))
    times = np.array([0.0, 0.3, 1.0])
    assert all(np.array_equal(one, other) for one, other in zip(found.curves(times), fresh.curves(times), strict=True))


def reached(system: System) -> list[dict[str, set[int]]]:
    """Whose numbers have a derivative by each variable."""
    return [{group: set(getattr(each, group)) for group in GROUPS} for each in system.derivatives]


def moved(scene: Scene, *paths: str) -> Scene:
    """The scene with some numbers changed."""
    for path in paths:
        scene = scene.with_number(path, float(np.real(scene.number(path))) * (1 + MOVED))
    return scene


def renews(systems: dict[tuple[str, ...], System], scene: Scene, *paths: str) -> None:
    """Each system, compiled with some variables, renewed at other numbers is what compiling anew makes."""
    other = moved(scene, *paths)
    for variables, system in systems.items():
        try:
            fresh = prepare(other, list(variables))
        except InputError:  # a reduced model that is fixed at its nominal design, or radii that fit no more
            for path in paths if len(paths) > 1 else ():
                renews(systems, scene, path)
            return
        assert_same(renewed(system, other, list(paths)), fresh)


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.parent.name)
def test_every_design_variable_of_every_model_renews_as_compiling_anew_does(path):
    scene = read_scene(path)
    variables = list(scene.design)
    systems = {names: prepare(scene, list(names)) for names in ((), tuple(variables))}
    for each in scene.design_variables():
        renews(systems, scene, each.path)


@pytest.mark.parametrize("name", EVERY)
def test_every_number_of_every_kind_of_component_renews_as_compiling_anew_does(name, folder):
    """Two at a time, far apart in the scene: neighbours in one vector, which touch the same, are moved beside different others."""
    scene = EVERY[name](folder)
    paths = [path for path in scene.available_paths() if float(np.real(scene.number(path))) != 0.0]
    variables = paths[:: max(len(paths) // 4, 1)]
    systems = {tuple(variables): prepare(scene, variables)}
    half = (len(paths) + 1) // 2
    for two in zip_longest(paths[:half], paths[half:]):
        renews(systems, scene, *filter(None, two))


def wing() -> Scene:
    return read_scene(MODELS[0].parents[1] / "morphing_wing" / "scene.toml")


def test_several_numbers_at_once_one_after_the_other_and_back_again():
    scene = wing()
    variables, system = list(scene.design), prepare(scene, list(scene.design))
    paths = [each.path for each in scene.design_variables()]
    other = scene
    for path in paths:
        other = other.with_number(path, scene.number(path) * (1 + MOVED))
    at_once = renewed(system, other, paths)
    assert_same(at_once, prepare(other, variables))
    assert at_once.numbering is system.numbering
    assert at_once.lu_plan is system.lu_plan
    assert_same(renewed(at_once, scene, paths), system)


def test_several_numbers_in_one_copy_are_those_one_after_the_other():
    scene = wing()
    values = {each.path: each.value * (1 + MOVED) for each in scene.design_variables()} | {
        "points.D.y": 3.9,
        "loads.drive.torque": 4.3e3,
    }
    one_by_one = scene
    for path, value in values.items():
        one_by_one = one_by_one.with_number(path, value)
    assert scene.with_all(values) == one_by_one
    assert scene.with_all(values) != scene


def markers(*columns: int) -> Quantities:
    """Numbers of a scene with nothing but a marker that feels some coordinates."""
    part = MarkerNumbers(np.zeros(3), np.array(columns), np.arange(3.0 * len(columns)).reshape(-1, 3) + 1)
    return Quantities({}, {}, {}, {}, {0: part}, {}, {}, {}, np.zeros(2), {})


def test_numbers_take_their_places_among_the_known_entries_and_ask_for_new_ones_where_there_are_none():
    known = markers(0, 2, 5)
    changed: set[str] = set()
    found = renew(known, markers(0, 5), known, changed)
    assert changed == {"markers"}
    np.testing.assert_array_equal(found.markers[0].columns, [0, 2, 5])
    np.testing.assert_array_equal(found.markers[0].shape, [[1, 2, 3], [0, 0, 0], [4, 5, 6]])
    with pytest.raises(NewEntryError):
        renew(known, markers(0, 3), known, changed)


def imaginary(part: Any) -> bool:
    """Whether anything of an item's numbers has an imaginary part."""
    if isinstance(part, tuple):
        return any(map(imaginary, part))
    if isinstance(part, Curve):
        return any(np.imag(value) != 0 for _, value in part.numbers())
    return bool(np.any(np.imag(part) != 0))


@pytest.mark.parametrize("name", EVERY)
def test_a_formula_that_is_left_out_has_no_derivative(name, folder):
    scene = loaded(EVERY[name](folder))
    numbering = number(scene)
    design = scene.design_variables(scene.available_paths())
    _, seen = seen_quantities(scene, numbering)
    left_out = 0
    for variable, rates in zip(design, derivatives(scene, numbering, design, seen), strict=True):
        everything = evaluate_quantities(scene.moved(variable, 1j * STEP), numbering)
        for group in GROUPS:
            numbers, known = getattr(everything, group), getattr(rates, group)
            assert not any(imaginary(numbers[owner]) for owner in numbers.keys() - known.keys()), (variable.name, group)
            left_out += len(numbers) - len(known)
    assert left_out


def test_a_scene_that_needs_a_new_entry_is_compiled_anew(monkeypatch):
    def full(*_: object, **__: object) -> None:
        raise NewEntryError

    scene = wing()
    system, path = prepare(scene, ["t_w"]), "loads.drive.torque"
    monkeypatch.setattr("toolkit.system.renewal.renew", full)
    other = moved(scene, path)
    found = renewed(system, other, [path])
    assert found.numbering is not system.numbering
    assert_same(found, prepare(other, ["t_w"]))


class Switched(Torque):
    """A torque that counts the place of its point where it is large."""

    kind = ""

    def parameters(self, scene: Any) -> list[Any]:
        """Its number, and from 5000 on times a coordinate."""
        return [self.torque * (scene.position(self.point)[0] if np.real(self.torque) > 5000 else 1.0)]


def test_a_load_that_asks_for_a_point_at_some_numbers_alone_has_its_derivative_there():
    scene = wing()
    drive = Switched.model_construct(**dict(scene.loads["drive"]))
    scene = scene.model_copy(update={"loads": {"drive": drive}})
    variables, path = ["x_A", "M_t"], "loads.drive.torque"
    other = scene.with_number(path, 6000.0)
    fresh = prepare(other, variables)
    assert fresh.derivatives[0].loads[0][0] == 6000.0
    assert_same(renewed(prepare(scene, variables), other, [path]), fresh)


def test_redundant_joints_are_sought_anew():
    """Other numbers may make other joints redundant."""
    scene = wing()
    scene = scene.model_copy(update={"solver": scene.solver.model_copy(update={"redundant": "least-squares"})})
    system, other = prepare(scene), scene.with_number("points.A.x", 70.0)
    assert renewed(system, other, ["points.A.x"]).numbering is not system.numbering


def test_a_number_that_becomes_zero_leaves_a_place_that_does_no_harm():
    scene = read_scene(MODELS[0].parents[1] / "slider_crank" / "scene.toml")
    path = next(path for path in scene.available_paths() if path.startswith("loads.") and float(scene.number(path)))
    other = scene.with_number(path, 0.0)
    variables = list(scene.design)
    values = [
        evaluate_with_gradients(solve(system, "transient"))
        for system in (renewed(prepare(scene, variables), other, [path]), prepare(other, variables))
    ]
    for name, value in values[1][0].items():
        np.testing.assert_allclose(values[0][0][name], value, rtol=1e-10)  # sums in another order


def test_curves_that_a_system_remembers_are_those_of_its_own_numbers():
    scene = read_scene(next(path for path in MODELS if path.parent.name == "morphing_wing"))
    (path,) = (each for each in scene.available_paths() if each.endswith("curve.duration"))
    system = prepare(scene, [path])
    (curve,) = system.values.curves.values()
    (slope,) = (rates.curves[0] for rates in system.derivatives)
    sets = [np.linspace(0.0, 1.0 + 0.1 * k, 5) for k in range(6)]  # more than are remembered
    for times in (*sets, *sets):
        for found, expected in zip(
            system.curves(times), (curve.evaluate(times), np.imag(slope.evaluate(times)) / STEP), strict=True
        ):
            assert np.array_equal(found[:, 0], expected)
            found[:] = np.nan  # whoever has them may write to them
    moved = scene.with_number(path, 2.0 * scene.number(path))
    for found, expected in zip(
        renewed(system, moved, [path]).curves(sets[0]), prepare(moved, [path]).curves(sets[0]), strict=True
    ):
        assert np.array_equal(found, expected)
