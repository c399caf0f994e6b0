"""Numbers of a scene that are likely to be in other units than the scene says: materials, thicknesses, masses, gravity."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from toolkit.components.bodies.body import Body
from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.bodies.rigid import GivenMass, UniformRod
from toolkit.components.markers.component import Component
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import SCENE, Caution, check
from toolkit.reduced_model.questions import IN_SI, material_questions
from toolkit.scene.resolution import ResolvedScene

LARGEST_SLENDER_THICKNESS, LEAST_THICKNESS = 3.0, 2e-5
"""Thickness of a flexible body in radii of gyration above and below which it is questioned."""
LARGEST_ROD_THICKNESS = 3.0
"""Thickness of a rod, the root of its area, in lengths, above which it is questioned."""
LARGEST_DENSITY, LEAST_JOINT_DISTANCE = 1e3 * 2.26e4, 0.1
"""Mass of a rigid body over the cube of the distance of its joints, in kg/m^3, above which it is questioned, and that distance, in
extents of the points, from which it tells anything. A thousand times osmium: a body may be ten times larger than the distance."""
LARGEST_GYRATION_RADIUS = 30.0
"""Radius of gyration of a rigid body, in extents of the scene's points, above which its inertia is questioned."""
EARTH = {"m-kg-s": 9.81, "mm-t-s": 9810.0}
READ_AS = {"m-kg-s": ("mm/s^2", 9810.0), "mm-t-s": ("m/s^2", 9.81)}
STANDARD = 9.78, 9.84
"""Gravity of the earth in m/s^2, from the equator to the poles: who writes it in a scene of mm has forgotten a factor of 1000, and nobody
needs a thousandth of it. 9810 m/s^2 may be a centrifuge."""
EARTH_GRAVITY_TOLERANCE = 0.06
"""Relative distance from the earth's gravity within which a number is meant to be it: also 10 m/s^2 and 9.78, but no other planet's."""


@check("unit-of-density", (SCENE,))
def unlikely_materials(scene: ResolvedScene) -> Iterator[Caution]:
    """Materials of bodies that no material is, or that are those of other units."""
    return _said_once(scene, _of_material)


def _said_once(scene: ResolvedScene, check_of: Callable[[ResolvedScene, str, Body], Iterator[Caution]]) -> Iterator[Caution]:
    """Cautions about the bodies of a scene; what many of them share is said once."""
    said: set[str] = set()
    for name, body in scene.bodies.items():
        for caution in check_of(scene, name, body):
            alike = caution.text.replace(f"bodies.{name}", "")
            if alike not in said:
                said.add(alike)
                yield caution


def _numbers(scene: ResolvedScene, body: ModelBody) -> dict[str, float]:
    values = {**scene.model(body.model).nominal, **body.model_values()}
    return {key: float(np.real(value)) for key, value in values.items()}


def _of_material(scene: ResolvedScene, name: str, body: Body) -> Iterator[Caution]:
    if isinstance(body, ModelBody):
        yield from material_questions(_numbers(scene, body), scene.units, f"bodies.{name}")
    elif isinstance(body, UniformRod):
        yield from material_questions({"density": float(np.real(body.density))}, scene.units, f"bodies.{name}")


@check("unit-of-thickness", (SCENE,))
def unlikely_thicknesses(scene: ResolvedScene) -> Iterator[Caution]:
    """The thickness of a body is out of proportion to its size.

    Limit: 3 times the radius of gyration, or 2e-5 of it.
    Fix: the unit system of the scene.
    """
    return _said_once(scene, _of_thickness)


def _of_thickness(scene: ResolvedScene, name: str, body: Body) -> Iterator[Caution]:
    if not isinstance(body, ModelBody):
        return
    where, size, length = f"bodies.{name}", body.radius_of_gyration(scene), unit(scene.units, "length")
    values = {key: value for key, value in _numbers(scene, body).items() if key.startswith("thickness")}
    odd = {key: t for key, t in values.items() if not LEAST_THICKNESS * size <= t <= LARGEST_SLENDER_THICKNESS * size}
    for key, thickness in list(odd.items())[:1]:
        yield unlikely_thicknesses.caution(
            f"{where}.{key} = {thickness:g} {length} is {thickness / size:.2g} times the size of the body, whose radius of gyration is "
            f"{size:.3g} {length}: is it in another unit?",
            doubt=False,
        )


@check("unit-of-area", (SCENE,))
def unlikely_areas(scene: ResolvedScene) -> Iterator[Caution]:
    """The area of a rod makes it thicker than it is long: it may be in another unit.

    Limit: 3 times as thick as long.
    Fix: the unit system of the scene.
    """
    return _said_once(scene, _of_rod)


def _of_rod(scene: ResolvedScene, name: str, body: Body) -> Iterator[Caution]:
    if not isinstance(body, UniformRod):
        return
    start, end = (np.real(scene.position(point)) for point in body.between)
    long, thick = float(np.linalg.norm(end - start)), float(np.sqrt(np.real(body.area)))
    if thick > LARGEST_ROD_THICKNESS * long:
        yield unlikely_areas.caution(
            f"bodies.{name}.area = {np.real(body.area):g} {unit(scene.units, 'area')} makes the rod {thick / long:.2g} times as "
            "thick as it is long: is it in another unit?",
            doubt=False,
        )


@check("unit-of-mass", (SCENE,))
def unlikely_masses(scene: ResolvedScene) -> Iterator[Caution]:
    """The mass of a rigid body is that of none of its size.

    Limit: 1000 times the density of osmium.
    Fix: the unit system of the scene.
    """
    return _said_once(scene, _of_mass)


def _of_mass(scene: ResolvedScene, name: str, body: Body) -> Iterator[Caution]:
    if not isinstance(body, GivenMass):
        return
    span = _span(scene, name)
    if (
        span > LEAST_JOINT_DISTANCE * _extent(scene)
        and float(np.real(body.mass)) / span**3 * IN_SI[scene.units]["density"] > LARGEST_DENSITY
    ):
        yield unlikely_masses.caution(
            f"bodies.{name}.mass = {float(np.real(body.mass)):g} {unit(scene.units, 'mass')} is that of no body whose joints are "
            f"{span:.3g} {unit(scene.units, 'length')} apart: is it in another unit?",
            doubt=False,
        )


@check("unit-of-inertia", (SCENE,))
def unlikely_inertias(scene: ResolvedScene) -> Iterator[Caution]:
    """The inertia of a rigid body with its mass is that of one far larger than the scene.

    Limit: a radius of gyration of 30 times the extent of the scene's points.
    Fix: the unit system of the scene.
    """
    return _said_once(scene, _of_inertia)


def _of_inertia(scene: ResolvedScene, name: str, body: Body) -> Iterator[Caution]:
    extent, length = _extent(scene), unit(scene.units, "length")
    if isinstance(body, GivenMass) and extent and (radius := body.radius_of_gyration(scene)) > LARGEST_GYRATION_RADIUS * extent:
        yield unlikely_inertias.caution(
            f"bodies.{name}.inertia with its mass is that of a body with a radius of gyration of {radius:.3g} {length}, in a scene of "
            f"{extent:.3g} {length}: is one of them in another unit?",
            doubt=False,
        )


def _span(scene: ResolvedScene, name: str) -> float:
    """Largest distance between points where joints and loads grip a body; 0 with fewer than two."""
    components = [each for each in (*scene.joints.values(), *scene.loads.values()) if isinstance(each, Component)]
    places = {point for each in components for body, point in each.grips if body == name}
    positions = np.array([np.real(scene.position(point)) for point in sorted(places)])
    return float(np.linalg.norm(positions[:, None] - positions[None], axis=-1).max()) if len(positions) > 1 else 0.0


def _extent(scene: ResolvedScene) -> float:
    """Extent of the points; 0 if there are fewer than two."""
    positions = np.array([np.real(scene.position(point)) for point in scene.points])
    return float(np.ptp(positions, axis=0).max()) if len(positions) > 1 else 0.0


@check("unit-of-gravity", (SCENE,))
def unlikely_gravity(scene: ResolvedScene) -> Iterator[Caution]:
    """Gravity has the digits of 9.81 m/s2 in a scene in mm.

    Limit: 9.78 to 9.84 in mm-t-s.
    Fix: 9810 mm/s2.
    """
    size, (reads, meant) = float(np.linalg.norm(np.real(scene.gravity))), READ_AS[scene.units]
    if abs(size / meant - 1) <= EARTH_GRAVITY_TOLERANCE:
        label = f"{unit(scene.units, 'length')}/s^2"
        yield unlikely_gravity.caution(
            f"gravity of {size:g} reads as {reads}; in {scene.units} its unit is {label}, and that of the earth is "
            f"{EARTH[scene.units]:g} {label}.",
            doubt=scene.units == "mm-t-s" and STANDARD[0] <= size <= STANDARD[1],
        )
