"""Units of design variables, as far as their paths tell."""

from __future__ import annotations

from toolkit.bodies.model_body import ModelBody
from toolkit.scene import Scene
from toolkit.units import unit

_BY_KEY = {
    "area": "area", "density": "density", "mass": "mass", "torque": "torque", "angle": "angle", "duration": "time", "start": "time",
    "thickness": "length",
}  # fmt: skip
_BY_GROUP = {"points": "length"}
_BY_OWNER = {"force": "force", "position": "length"}


def variable_unit(scene: Scene, path: str) -> str:
    """Label of the unit of the number at a path; empty where the path does not tell."""
    group, name, *rest = path.split(".")
    body = scene.bodies.get(name) if group == "bodies" else None
    if isinstance(body, ModelBody) and rest[-1] in (units := scene.model(body.model).nominal_units):
        return units[rest[-1]]
    quantity = _BY_GROUP.get(group) or _BY_KEY.get(rest[-1]) or _BY_OWNER.get(rest[0]) or "none"
    return unit(scene.units, quantity)


def per(numerator: str, denominator: str) -> str:
    """Label of a quotient, for example "MPa / mm"."""
    if not denominator:
        return numerator
    return f"{numerator or '1'} / ({denominator})" if " " in denominator else f"{numerator or '1'} / {denominator}"
