"""Numbers of a scene that are likely to be in other units than the scene says: materials, thicknesses, masses, gravity."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.bodies.mass import GivenMass, UniformRod
from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.markers.component import Component
from toolkit.reduced_model.questions.material_questions import IN_SI, material_questions
from toolkit.scene.resolution import ResolvedScene

THICK, THIN = 3.0, 2e-5
"""Thickness of a flexible body in radii of gyration above and below which it is questioned."""
STOUT = 3.0
"""Thickness of a rod, the root of its area, in lengths, above which it is questioned."""
DENSEST, APART = 1e3 * 2.26e4, 0.1
"""Mass of a rigid body over the cube of the distance of its joints, in kg/m^3, above which it is questioned, and that distance, in
extents of the points, from which it tells anything. A thousand times osmium: a body may be ten times larger than the distance."""
FAR_OUT = 30.0
"""Radius of gyration of a rigid body, in extents of the scene's points, above which its inertia is questioned."""
EARTH = {"m-kg-s": 9.81, "mm-t-s": 9810.0}
READ_AS = {"m-kg-s": ("mm/s^2", 9810.0), "mm-t-s": ("m/s^2", 9.81)}
STANDARD = 9.78, 9.84
"""Gravity of the earth in m/s^2, from the equator to the poles: who writes it in a scene of mm has forgotten a factor of 1000, and nobody
needs a thousandth of it. 9810 m/s^2 may be a centrifuge."""
LIKE_EARTH = 0.06
"""Relative distance from the earth's gravity within which a number is meant to be it: also 10 m/s^2 and 9.78, but no other planet's."""


def cautions_of_units(scene: ResolvedScene) -> Iterator[Caution]:
    """Cautions of all numbers of a scene that no material has, or that are those of other units; what many bodies share is said once."""
    said: set[str] = set()
    for name, body in scene.bodies.items():
        for caution in _of_body(scene, name, body):
            alike = caution.text.replace(f"bodies.{name}", "")
            if alike not in said:
                said.add(alike)
                yield caution
    yield from _of_gravity(scene)


def _of_body(scene: ResolvedScene, name: str, body) -> Iterator[Caution]:
    where = f"bodies.{name}"
    if isinstance(body, ModelBody):
        values = {**scene.model(body.model).nominal, **body.model_values()}
        numbers = {key: float(np.real(value)) for key, value in values.items()}
        yield from material_questions(numbers, scene.units, where)
        yield from _of_thickness(scene, where, body, numbers)
    elif isinstance(body, UniformRod):
        yield from material_questions({"density": float(np.real(body.density))}, scene.units, where)
        yield from _of_rod(scene, where, body)
    elif isinstance(body, GivenMass):
        yield from _of_mass(scene, name, body)


def _of_thickness(scene: ResolvedScene, where: str, body: ModelBody, values: dict[str, float]) -> Iterator[Caution]:
    size, length = body.radius_of_gyration(scene), unit(scene.units, "length")
    odd = {key: t for key, t in values.items() if key.startswith("thickness") and not THIN * size <= t <= THICK * size}
    for key, thickness in list(odd.items())[:1]:
        yield Caution(
            "unit-of-thickness",
            f"{where}.{key} = {thickness:g} {length} is {thickness / size:.2g} times the size of the body, whose radius of gyration is "
            f"{size:.3g} {length}: is it in another unit?",
            doubt=False,
        )


def _of_rod(scene: ResolvedScene, where: str, body: UniformRod) -> Iterator[Caution]:
    start, end = (np.real(scene.position(point)) for point in body.between)
    long, thick = float(np.linalg.norm(end - start)), float(np.sqrt(np.real(body.area)))
    if thick > STOUT * long:
        yield Caution(
            "unit-of-area",
            f"{where}.area = {np.real(body.area):g} {unit(scene.units, 'area')} makes the rod {thick / long:.2g} times as thick as it is "
            "long: is it in another unit?",
            doubt=False,
        )


def _of_mass(scene: ResolvedScene, name: str, body: GivenMass) -> Iterator[Caution]:
    mass, length = float(np.real(body.mass)), unit(scene.units, "length")
    span = _span(scene, name)
    if span > APART * _extent(scene) and mass / span**3 * IN_SI[scene.units]["density"] > DENSEST:
        yield Caution(
            "unit-of-mass",
            f"bodies.{name}.mass = {mass:g} {unit(scene.units, 'mass')} is that of no body whose joints are {span:.3g} {length} apart: is "
            "it in another unit?",
            doubt=False,
        )
    extent = _extent(scene)
    if extent and (radius := body.radius_of_gyration(scene)) > FAR_OUT * extent:
        yield Caution(
            "unit-of-inertia",
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


def _of_gravity(scene: ResolvedScene) -> Iterator[Caution]:
    size, (reads, meant) = float(np.linalg.norm(np.real(scene.gravity))), READ_AS[scene.units]
    if abs(size / meant - 1) <= LIKE_EARTH:
        label = f"{unit(scene.units, 'length')}/s^2"
        yield Caution(
            "unit-of-gravity",
            f"gravity of {size:g} reads as {reads}; in {scene.units} its unit is {label}, and that of the earth is "
            f"{EARTH[scene.units]:g} {label}.",
            doubt=scene.units == "mm-t-s" and STANDARD[0] <= size <= STANDARD[1],
        )
