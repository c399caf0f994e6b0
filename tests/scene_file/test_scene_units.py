"""A scene in other units is the same scene: its responses and gradients agree to round-off after they are converted back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from typing import Annotated, Any, get_args

import numpy as np
import pytest

from preprocessing.builders.frame_recipe import polygon_beam
from preprocessing.elements.section import Section
from tests.models.cases import write_models
from tests.models.every_number import SCENES
from tests.models.scenes import HANGING_DESIGN, WING, hanging_skin
from toolkit.analyses.sensitivity.direct import direct
from toolkit.components.curves.curve import Curve
from toolkit.components.curves.oscillation import Sine
from toolkit.components.joints.revolute import Revolute
from toolkit.components.loads.load import PlanarLoad
from toolkit.components.loads.point_force import point_force
from toolkit.description.description import Description, Number, Quantity
from toolkit.files.gradient_units import converted, number_factor, response_factor
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LABELLED, UNIT_SYSTEMS, Dimension, factor
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.file import load
from toolkit.reduced_model.model import ReducedModel
from toolkit.responses.stress import KSStress
from toolkit.scene.scene import Scene


def other(units: str) -> str:
    return next(name for name in UNIT_SYSTEMS if name != units)


def differences(scene: Scene, design: list[str], folder) -> tuple[float, float]:
    """Largest relative difference of values, and of gradients beside the largest change of that response by a variable's own size."""
    units = other(scene.units)
    here, there = (direct(each, design, "transient") for each in (scene, converted(scene, units, folder)))
    values, slopes = [0.0], [0.0]
    for f, value in here.values.items():
        by = response_factor(scene, f, units)
        values.append(abs(there.values[f] / by - value) / max(abs(value), 1e-300))
        paths = {x: scene.design.get(x, x) for x in here.gradients[f]}
        found = {x: there.gradients[f][x] / by * number_factor(scene, path, units) for x, path in paths.items()}
        sizes = {x: abs(np.real(scene.number(path))) or 1.0 for x, path in paths.items()}
        scale = max(abs(here.gradients[f][x]) * sizes[x] for x in paths)
        slopes += [abs(found[x] - here.gradients[f][x]) * sizes[x] / scale for x in paths if np.isfinite(found[x])]
    return max(values), max(slopes)


def arrays(item: Any) -> Iterator[np.ndarray]:
    """All arrays of a reduced model or of a part of it, in their order."""
    if isinstance(item, np.ndarray):
        yield item
    elif isinstance(item, (dict, tuple)):
        for below in item.values() if isinstance(item, dict) else item:
            yield from arrays(below)
    elif is_dataclass(item):
        for field in fields(item):
            yield from arrays(getattr(item, field.name))


def beam(units: str) -> ReducedModel:
    """A bent beam whose numbers are written in a unit system."""
    length, density = (factor(LABELLED[name], "m-kg-s", units) for name in ("length", "density"))
    section = Section(
        youngs_modulus=70e9 * factor(LABELLED["stress"], "m-kg-s", units),
        density=2700 * density,
        thickness=0.01 * length,
        width=0.05 * length,
        damping_mass=0.3,
        damping_stiffness=1e-4,
    )
    nodes = np.array([[0.0, 0.0], [0.3, 0.1], [0.5, 0.3], [0.6, 0.7]]) * length
    return polygon_beam(nodes, section, {"inside": 0.4 * length, "node": 0.0}, units)


def test_a_converted_model_is_the_one_that_preprocessing_makes_in_the_other_units():
    made, found = beam("mm-t-s"), converted_model(beam("m-kg-s"), "mm-t-s")
    assert found.nominal == pytest.approx(made.nominal, rel=1e-14)
    assert found.nominal_units == made.nominal_units
    thick = [
        DesignPoint(each, {name: 1.1 * value for name, value in each.nominal.items()}).invariants() for each in (found, made)
    ]
    ours, theirs = arrays((replace(found, affine=None), thick[0])), arrays((replace(made, affine=None), thick[1]))
    for one, other in zip(ours, theirs, strict=True):
        # round-off of the invariants' sums, beside the largest entry of each array
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12 * np.abs(other).max(initial=0))


def test_there_and_back_is_the_same_model():
    model = load(WING.with_name("skin.h5"))
    back = converted_model(converted_model(model, "m-kg-s"), "mm-t-s")
    assert back.nominal_units == model.nominal_units
    for one, other in zip(arrays(back), arrays(model), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14)  # two multiplications of each number, and 1 / 1e-3 is rounded


@pytest.mark.parametrize("name", SCENES)
def test_scenes_with_every_kind_of_component_do_not_depend_on_the_units(name, tmp_path):
    write_models(tmp_path)
    scene = SCENES[name](tmp_path)
    values, slopes = differences(scene, scene.available_paths(), tmp_path)
    # both runs round differently; Newton leaves 1e-10 of the model size, and squares that error in the step it stops at
    assert values < 1e-9
    # each derivative beside the largest of its response; a skin is 1e9 times stiffer in tension than in bending
    assert slopes < 1e-8


@pytest.mark.parametrize("scene", [read_scene(WING), hanging_skin()], ids=["wing", "hanging skin"])
def test_scenes_with_a_meshed_skin_do_not_depend_on_the_units(scene, tmp_path):
    values, slopes = differences(scene, list(scene.design) or HANGING_DESIGN, tmp_path)
    # both runs round differently; Newton leaves 1e-10 of the model size, and squares that error in the step it stops at
    assert values < 1e-9
    # each derivative beside the largest of its response; a skin is 1e9 times stiffer in tension than in bending
    assert slopes < 1e-8


class Weighing(Revolute):
    """A joint with a number that nobody has given a dimension."""

    kind = ""  # not for scene files
    limit: Number = 2.0


def test_a_number_of_unknown_dimension_is_refused_by_name(tmp_path):
    scene = SCENES["swing"](tmp_path)
    joints = {**scene.joints, "hinge": Weighing(bodies=("rod", "ground"), point="O")}
    with pytest.raises(InputError, match="'limit' of a Weighing"):
        converted(scene.model_copy(update={"joints": joints}), "mm-t-s", tmp_path)


class Silent(PlanarLoad):
    """A load with a time curve of which nobody has said what its values are."""

    formula = point_force
    body: str
    curve: Curve = Sine(amplitude=2.0, frequency=3.0)

    @property
    def grips(self) -> tuple[tuple[str, str], tuple[str, str]]:
        """The body at its end."""
        return (self.body, "O"), ("ground", "O")

    def parameters(self, _scene) -> list[Any]:
        """None."""
        return []


class Dashing(Silent):
    """The same, and what the values are stands beside the curve."""

    curve: Annotated[Curve, Quantity("length/time")] = Sine(amplitude=2.0, frequency=3.0)


def test_values_of_a_curve_are_what_is_said_beside_it_and_refused_by_name_if_nothing_is(tmp_path):
    scene = SCENES["swing"](tmp_path)
    dashing = scene.model_copy(update={"loads": {"wind": Dashing(body="rod")}})
    found = converted(dashing, "mm-t-s", tmp_path)
    assert [found.number(f"loads.wind.curve.{key}") for key in ("amplitude", "frequency")] == [2000.0, 3.0]
    silent = scene.model_copy(update={"loads": {"wind": Silent(body="rod")}})
    with pytest.raises(
        InputError, match=r"values of the time curve of a Silent are.* beside the field: `curve: Annotated\[Curve"
    ):
        converted(silent, "mm-t-s", tmp_path)


def fields_below(kind: type) -> Iterator[type]:
    """A class of descriptions and all below it that the toolkit brings."""
    for each in kind.__subclasses__():
        if each.__module__.startswith("toolkit."):
            yield from (each, *fields_below(each))


def holds_numbers(annotation: Any) -> bool:
    """Whether a field's type has a floating-point number in it."""
    return annotation is float or any(holds_numbers(part) for part in get_args(annotation))


def test_what_a_number_measures_stands_beside_every_field_of_the_toolkit():
    """A new field without it would be refused only when somebody converts a scene that has it; studies are not converted."""
    asked = [
        (kind, name)
        for kind in fields_below(Description)
        if not kind.__module__.startswith("toolkit.studies.")
        for name, info in kind.model_fields.items()
        if holds_numbers(info.annotation)
    ]
    assert len(asked) > 150
    silent = [
        f"{kind.__name__}.{name}"
        for kind, name in asked
        if not any(isinstance(each, Quantity) for each in kind.model_fields[name].metadata)
        and (kind, name) != (KSStress, "aggregation")
    ]
    assert silent == []


@pytest.mark.parametrize("words", ["lenght", "mass*length", "length/(time)"])
def test_words_that_measure_nothing_are_refused(words):
    with pytest.raises(InputError, match="names no quantity; its words are none, angle, length"):
        Quantity(words)


def test_words_multiply_to_dimensions():
    """By hand."""
    assert Quantity("force time/length").measure() == (Dimension(1, 0, -1), 0)
    assert Quantity("torque/angle").measure() == (Dimension(1, 2, -2), -1)
    assert [Quantity("length/time", "angle/time").measure(k) for k in (0, 1)] == [
        (Dimension(0, 1, -1), 0),
        (Dimension(0, 0, -1), 1),
    ]


def test_unknown_units_are_refused(tmp_path):
    with pytest.raises(InputError, match="available: mm-t-s, m-kg-s"):
        converted(SCENES["rods"](tmp_path), "in-lb-s", tmp_path)


def test_a_model_without_its_mesh_is_refused():
    with pytest.raises(InputError, match="without its mesh"):
        converted_model(load(WING.with_name("skin.h5"), ("affine",)), "m-kg-s")
