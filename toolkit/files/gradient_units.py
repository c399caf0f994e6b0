"""Units of design variables and of gradients: unit of the response over unit of the variable."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from toolkit.components.bodies.model_body import ModelBody
from toolkit.description.description import Description, Measure
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LABELLED, NONE, Dimension, factor, unit
from toolkit.reduced_model.conversion import converted_model
from toolkit.reduced_model.file import load, save
from toolkit.responses.response import Response
from toolkit.scene.design_variables import measure_in, number_measure
from toolkit.scene.scene import GROUPS, Scene


def dimensions(scene: Scene) -> dict[str, Dimension]:
    """Path -> dimension of every number that the scene writes.

    Raises
    ------
    InputError
        Nobody has said what the number of a component is: names class and field.
    """
    found = dict(_below("solver", scene.solver, scene))
    for group in GROUPS:
        for name, item in getattr(scene, group).items():
            found |= _below(f"{group}.{name}", item, scene)
    return found


def number_dimension(scene: Scene, path: str) -> Dimension:
    """Dimension of one number: one that the scene writes, or a parameter of a reduced model that it leaves at its nominal value.

    Raises
    ------
    InputError
        As `dimensions`.
    """
    return number_measure(scene, path).dimension


def response_dimension(response: Response) -> Dimension:
    """Dimension of a response's value."""
    return response.physical_dimension


def _below(where: str, item: Description, scene: Scene) -> Iterator[tuple[str, Dimension]]:
    for path, _ in item.numbers():
        yield f"{where}.{path}", measure_in(item, path.split("."), scene).dimension


def converted(scene: Scene, units: str, directory: Path) -> Scene:
    """Scene with all numbers in another unit system; its results are the same to round-off, in the new units.

    Parameters
    ----------
    scene : Scene
    units : "m-kg-s" or "mm-t-s"
    directory : folder that the converted reduced models are written to

    Raises
    ------
    InputError
        The unit system is unknown, or a kind of component whose numbers nobody has given a dimension.
    """
    found = scene
    for path, dimension in dimensions(scene).items():
        by = factor(dimension, scene.units, units)
        if by != 1:
            found = found.with_number(path, np.multiply(by, scene.number(path)).item())
    bodies = {name: _with_model(scene, body, units, directory) for name, body in found.bodies.items()}
    return found.model_copy(update={"units": units, "bodies": bodies, "directory": directory})


def _with_model(scene: Scene, body, units: str, directory: Path):
    if not isinstance(body, ModelBody):
        return body
    models = sorted({each.model for each in scene.bodies.values() if isinstance(each, ModelBody)})
    name = f"{Path(body.model).stem}_{models.index(body.model)}_{units}.h5"
    save(converted_model(load(scene.directory / body.model), units), directory / name)
    return body.model_copy(update={"model": name})


def response_factor(scene: Scene, response: str, units: str) -> float:
    """Factor that turns the value of a response into other units."""
    found = scene.responses[response]
    return factor(response_dimension(found), scene.units, units) if isinstance(found, Response) else 1.0


def number_factor(scene: Scene, path: str, units: str) -> float:
    """Factor that turns the number at a path into other units."""
    return factor(number_dimension(scene, path), scene.units, units)


_BASE = ("mass", "length", "time")


def variable_unit(scene: Scene, path: str) -> str:
    """Label of the unit of the number at a path, for example "N/mm"; empty for a number without one.

    A number of a component of which nobody has said what it measures (see `toolkit.description.description`) has the label "?".
    """
    group, name, *keys = path.split(".")
    item = getattr(scene, group)[name]
    if isinstance(item, ModelBody) and keys[-1] in (units := scene.model(item.model).nominal_units):
        return units[keys[-1]]
    try:
        return measure_label(number_measure(scene, path), scene.units)
    except InputError:
        return "?"


def measure_label(measure: Measure, system: str) -> str:
    """Label of a unit that an angle may be part of, for example "rad/s" or "N m/rad"."""
    label = dimension_label(measure.dimension, system)
    if not measure.angle:
        return label
    angle = _product([(unit(system, "angle"), measure.angle)])
    if measure.angle < 0:
        return (label or "1") + angle.removeprefix("1")
    return angle + label.removeprefix("1") if label.startswith("1/") else f"{angle} {label}".rstrip()


def dimension_label(dimension: Dimension, system: str) -> str:
    """Label of a unit, for example "kg m^2"; units made of a force have the system's own unit of force."""
    if dimension == NONE:
        return ""
    known = next((quantity for quantity, each in LABELLED.items() if each == dimension), None)
    if known is not None:
        return unit(system, known)
    if dimension.mass == 1 and dimension.time < 0:  # a force times length and time
        rest = Dimension(0, dimension.length - 1, dimension.time + 2)
        return _product([(unit(system, "force"), 1), *_powers(rest, system)])
    if dimension.mass == -1 and dimension.time > 0:
        return f"1/{_bracketed(dimension_label(dimension.power(-1), system))}"
    return _product(_powers(dimension, system))


def _powers(dimension: Dimension, system: str) -> list[tuple[str, int]]:
    return [(unit(system, quantity), power) for quantity, power in zip(_BASE, dimension, strict=True) if power]


def _product(powers: Iterable[tuple[str, int]]) -> str:
    """Label of units with their powers, those below the line behind one slash each."""
    above = [label if power == 1 else f"{label}^{power}" for label, power in powers if power > 0]
    below = [label if power == -1 else f"{label}^{-power}" for label, power in powers if power < 0]
    return "/".join([" ".join(above) or "1", *below])


def _bracketed(label: str) -> str:
    return f"({label})" if set(label) & set(" /") else label


def per(numerator: str, denominator: str) -> str:
    """Label of a quotient of units, for example "MPa / mm"."""
    return f"{numerator or '1'} / {_bracketed(denominator)}" if denominator else numerator


def gradient_unit(scene: Scene, response: str, variable: str) -> str:
    """Unit of the derivative of a response by a design variable, by its short name or path: "J s / (N/m)"."""
    found = scene.responses[response]
    numerator = found.unit(scene.units) if isinstance(found, Response) else ""
    return per(numerator, variable_unit(scene, scene.paths_of(variable)[0]))


def gradient_units(scene: Scene, gradients: Mapping[str, Iterable[str]]) -> dict[str, dict[str, str]]:
    """Units of gradients: response -> variable -> unit, for the names of the gradients of a result."""
    return {response: {x: gradient_unit(scene, response, x) for x in variables} for response, variables in gradients.items()}
