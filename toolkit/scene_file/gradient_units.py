"""Units of design variables and of gradients: unit of the response over unit of the variable."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from toolkit.bodies.model_body import ModelBody
from toolkit.description.description import Measure
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import LABELLED, NONE, Dimension, unit
from toolkit.responses.response import Response
from toolkit.scene.measures import number_measure
from toolkit.scene.scene import Scene

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
