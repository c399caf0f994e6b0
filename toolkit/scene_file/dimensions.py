"""The dimension of every number of a scene, by the class and the field that hold it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from toolkit.bodies.model_body import ModelBody
from toolkit.bodies.planar.flexible import Flexible
from toolkit.bodies.planar.rigid import Rigid, Rod
from toolkit.bodies.planar.start_velocity import StartVelocity
from toolkit.bodies.spatial.body import SpatialBody
from toolkit.bodies.spatial.flexible import SpatialFlexible
from toolkit.bodies.spatial.rigid import SpatialRigid, SpatialRod
from toolkit.description.description import Description
from toolkit.description.point import BodyPoint, Point
from toolkit.description.profile import CURVES
from toolkit.description.run_options import Baumgarte, RunOptions
from toolkit.foundation.dimensions import LABELLED, NONE, Dimension, dimension_of_label
from toolkit.foundation.errors import InputError
from toolkit.joints.planar.distance import Distance
from toolkit.joints.planar.driver import AngleDriver, PositionDriver
from toolkit.joints.planar.slider import AlongAxis
from toolkit.joints.spatial.distance import SpatialDistance
from toolkit.joints.spatial.driver import SpatialAngleDriver, SpatialPositionDriver
from toolkit.joints.spatial.joint import AxisJoint
from toolkit.joints.spatial.universal import Universal
from toolkit.loads.planar.gravity import Gravity
from toolkit.loads.planar.point_force import PointForce
from toolkit.loads.planar.spring_damper import RotationalSpringDamper, SpringDamper
from toolkit.loads.planar.torque import Torque
from toolkit.loads.spatial.gravity import SpatialGravity
from toolkit.loads.spatial.point_force import SpatialPointForce
from toolkit.loads.spatial.pressure import Pressure
from toolkit.loads.spatial.rotational_spring_damper import SpatialRotationalSpringDamper
from toolkit.loads.spatial.spring_damper import SpatialSpringDamper
from toolkit.loads.spatial.torque import SpatialTorque
from toolkit.responses.instant import Instant, TimeIntegral
from toolkit.responses.motion import Rotation
from toolkit.responses.response import Response
from toolkit.responses.stress.stress import KSStress
from toolkit.scene.scene import Scene

GROUPS = ("points", "bodies", "joints", "loads", "responses")
_LENGTH, _TIME, _RATE, _ENERGY = (LABELLED[name] for name in ("length", "time", "rate", "energy"))
_VELOCITY = (_LENGTH.times(_RATE), _LENGTH.times(_RATE), _RATE)
_STIFFNESS = LABELLED["force"].times(_LENGTH.power(-1))
_ACCELERATION = _LENGTH.times(_RATE.power(2))
_INERTIA = LABELLED["mass"].times(LABELLED["area"])
_Fields = dict[str, Dimension | tuple[Dimension, ...]]
_SPRING: _Fields = {"stiffness": _STIFFNESS, "damping": _STIFFNESS.times(_TIME), "length": _LENGTH}
_COIL: _Fields = {"stiffness": _ENERGY, "damping": _ENERGY.times(_TIME), "rest_angle": NONE}
_ROD: _Fields = {"area": LABELLED["area"], "density": LABELLED["density"]}

FIELDS: dict[type, _Fields] = {
    Point: {"x": _LENGTH, "y": _LENGTH, "z": _LENGTH},
    BodyPoint: {"arc_length": _LENGTH},
    StartVelocity: {"velocity": _VELOCITY, "angular_velocity": _RATE},
    Rigid: {"mass": LABELLED["mass"], "inertia": _INERTIA},
    Rod: _ROD,
    Flexible: {"position": _LENGTH, "angle": NONE},
    SpatialBody: {"axis": NONE, "velocity": _LENGTH.times(_RATE), "angular_velocity": _RATE},
    SpatialRigid: {"mass": LABELLED["mass"], "inertia": _INERTIA},
    SpatialRod: _ROD,
    SpatialFlexible: {"position": _LENGTH, "orientation": NONE},
    Distance: {"length": _LENGTH},
    SpatialDistance: {"length": _LENGTH},
    AlongAxis: {"axis": NONE},
    AxisJoint: {"axis": NONE},
    Universal: {"axes_of_cross": NONE},
    Torque: {"torque": LABELLED["torque"]},
    SpatialTorque: {"torque": LABELLED["torque"]},
    PointForce: {"force": LABELLED["force"]},
    SpatialPointForce: {"force": LABELLED["force"]},
    Pressure: {"pressure": LABELLED["stress"]},
    Gravity: {"acceleration": _ACCELERATION},
    SpatialGravity: {"acceleration": _ACCELERATION},
    SpringDamper: _SPRING,
    SpatialSpringDamper: _SPRING,
    RotationalSpringDamper: _COIL,
    SpatialRotationalSpringDamper: {**_COIL, "axis": NONE},
    Instant: {"time": _TIME},
    Rotation: {"axis": NONE},
    KSStress: {"reference_stress": LABELLED["stress"]},
    Baumgarte: {"damping": _RATE, "stiffness": _RATE},
    RunOptions: {
        "end_time": _TIME, "step": _TIME, "times": _TIME, "rho_inf": NONE, "tolerance": NONE, "drift_tolerance": NONE,
        "memory": NONE, "local_error": NONE,
    },
}  # fmt: skip
"""Class -> field -> dimension of its numbers, or of each of them; a new kind of component with numbers needs a line here."""

CURVE_VALUES: dict[type, Dimension] = {
    Torque: NONE, PointForce: NONE, AngleDriver: NONE, PositionDriver: _LENGTH,
    Pressure: NONE, SpatialTorque: NONE, SpatialPointForce: NONE, SpatialAngleDriver: NONE, SpatialPositionDriver: _LENGTH,
}  # fmt: skip
"""Owner of a time curve -> dimension of the curve's value."""
CURVE_FIELDS: dict[str, Dimension | None] = {
    "value": None, "height": None, "amplitude": None, "values": None, "start": _TIME, "duration": _TIME, "times": _TIME,
    "frequency": _RATE, "phase": NONE,
}  # fmt: skip
"""Dimension of a curve's numbers; None for those that are values of the curve."""


def dimensions(scene: Scene) -> dict[str, Dimension]:
    """Path -> dimension of every number that the scene writes.

    Raises
    ------
    InputError
        A kind of component is unknown to `FIELDS`: names class and field.
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
    path = scene.path_of(path)
    group, name, *rest = path.split(".")
    item = getattr(scene, group)[name]
    written = dict(_below(f"{group}.{name}", item, scene))
    return written[path] if path in written else _field(item, rest, scene)


def response_dimension(response: Response) -> Dimension:
    """Dimension of a response's value."""
    if isinstance(response, TimeIntegral):
        return response_dimension(response.of).times(_TIME)
    return LABELLED[response.unit_quantity]


def _below(where: str, item: Description, scene: Scene) -> Iterator[tuple[str, Dimension]]:
    for path, _ in item.numbers():
        yield f"{where}.{path}", _field(item, path.split("."), scene)


def _field(item: Any, keys: list[str], scene: Scene) -> Dimension:
    """Dimension of the number that keys lead to from an item."""
    field, *rest = keys
    if isinstance(item, ModelBody) and field not in type(item).model_fields:
        return _parameter(item, field, scene)
    known = next((FIELDS[kind][field] for kind in type(item).__mro__ if field in FIELDS.get(kind, {})), None)
    below = getattr(item, field, None)
    if isinstance(known, Dimension):
        return known
    if known is not None:
        return known[int(rest[0])]
    if isinstance(item, KSStress) and field == "aggregation":
        return LABELLED["stress"].power(-1) if item.reference_stress is None else NONE
    if isinstance(below, tuple(CURVES.values())):
        return _in_curve(item, rest)
    if isinstance(below, Description):
        return _field(below, rest, scene)
    raise InputError(
        f"nobody has said what the number {field!r} of a {type(item).__name__} is, so it cannot be given in other units. "
        "Add its dimension to toolkit.scene_file.dimensions.FIELDS."
    )


def _parameter(body: ModelBody, name: str, scene: Scene) -> Dimension:
    model = scene.model(body.model)
    if name not in model.nominal_units:
        raise InputError(f"reduced model {body.model!r} has no parameter {name!r}; available: {', '.join(model.nominal)}.")
    return dimension_of_label(model.nominal_units[name], model.units)


def _in_curve(owner: Any, keys: list[str]) -> Dimension:
    """Dimension of a number in a time curve; the last key that is no place in a list names it."""
    key = next(each for each in reversed(keys) if each in CURVE_FIELDS)
    found = CURVE_FIELDS[key]
    if found is not None:
        return found
    values = next((CURVE_VALUES[kind] for kind in type(owner).__mro__ if kind in CURVE_VALUES), None)
    if values is None:
        raise InputError(
            f"nobody has said what the values of the time curve of a {type(owner).__name__} are, so they cannot be given in other "
            "units. Add their dimension to toolkit.scene_file.dimensions.CURVE_VALUES."
        )
    return values
