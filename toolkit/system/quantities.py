"""All numbers of a scene in the order of its numbering, real or complex: the construction formulas evaluated once.

Derivatives of a scene's numbers by its design variables: a complex step through the construction formulas that a variable reaches.

That is exact to round-off, and it happens before time starts to run.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from operator import is_
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from toolkit.components.bodies.body import Body, ConstantNumbers, MarkerNumbers, Placed, SpatialMarkerNumbers
from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.curves.curve import Curve
from toolkit.components.joints.joint import Joint, JointBetweenPoints
from toolkit.components.loads.gravity import UniformGravity
from toolkit.components.loads.load import Load
from toolkit.components.loads.pressure import Pressure, PressureNumbers
from toolkit.components.loads.springs import PointSpring
from toolkit.components.markers.component import Component
from toolkit.description.design import Design
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.questions import check_parameters
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene
from toolkit.system.dependence import Affected, AskedScene, Item, Question, answers_alike
from toolkit.system.numbering import Numbering

if TYPE_CHECKING:
    from toolkit.components.bodies.flexible import SpatialFlexible

STEP = 1e-30
"""Complex step: far below round-off, so that nothing but the first derivative is left."""


@dataclass(frozen=True)
class Quantities:
    """Numbers of a scene, each under its number in the order of bodies, markers, joints, loads, curves.

    The values of a scene hold them all, their derivatives by one variable only those that the variable reaches, at whatever numbers.
    """

    start: dict[int, tuple[np.ndarray, np.ndarray]]  # coordinates and velocities of each body
    constant: dict[int, ConstantNumbers]
    floating: dict[int, Any]  # FloatingNumbers or SpatialFloatingNumbers of the bodies that have them
    drag: dict[int, Any]  # the same, times the mass-proportional damping
    markers: dict[int, Any]  # MarkerNumbers or SpatialMarkerNumbers
    joints: dict[int, np.ndarray]  # the numbers of the rows, see `joints.rows`
    loads: dict[int, np.ndarray]  # (5,) parameters, in space (7,)
    pressures: dict[int, PressureNumbers]
    gravity: np.ndarray  # (d,)
    curves: dict[int, Curve]


GROUPS = tuple(field.name for field in fields(Quantities) if field.name != "gravity")


class ItemPart(NamedTuple):
    """Share of one item in a group: what the scene writes about it, and its numbers as they follow from a scene."""

    written: tuple[Any, ...]
    make: Callable[[Any], Any]


Asked = dict[tuple[str, int], frozenset[Question]]
OPEN = ("joints", "loads")
"""Groups whose formulas anybody writes."""


class Seen(NamedTuple):
    """Record of how some numbers of a scene came about."""

    scene: ResolvedScene
    parts: dict[str, dict[int, ItemPart]]
    asked: Asked  # of the scene, for the numbers of an item

    @property
    def asked_by_components(self) -> Asked:
        """Questions that joints and loads have asked of the scene, by owner.

        Anybody may write their formulas, so that what they ask may depend on the scene's numbers.
        """
        return {owner: asked for owner, asked in self.asked.items() if owner[0] in OPEN}


Owners = Mapping[str, Collection[int]]
"""Group of `Quantities` -> some of those who have numbers in it."""


def evaluate_quantities(scene: ResolvedScene, numbering: Numbering, affected: Affected | None = None) -> Quantities:
    """Quantities of a scene, of all or of some items and markers."""
    return made_of(parts_of(scene, numbering, owners_of(scene, numbering, affected)), scene)


def seen_quantities(
    scene: ResolvedScene, numbering: Numbering, affected: Affected | None = None, watched: Collection[str] | None = None
) -> tuple[Quantities, Seen]:
    """Quantities of a scene and how they came about.

    What is asked for them is noted only in groups that are `watched`, by default in all.
    """
    notes, parts = AskedScene(scene), parts_of(scene, numbering, owners_of(scene, numbering, affected))
    asked: Asked = {}
    groups: dict[str, dict[int, Any]] = {group: {} for group in parts}
    for group, owners in parts.items():
        for owner, part in owners.items():
            if watched is None or group in watched:
                groups[group][owner], asked[group, owner] = notes.watched(part.make)
            else:
                groups[group][owner] = part.make(scene)
    return _quantities(groups, scene), Seen(scene, parts, asked)


def made_of(parts: Mapping[str, Mapping[int, ItemPart]], scene: ResolvedScene) -> Quantities:
    """Quantities from the parts of a scene."""
    return _quantities({group: {k: part.make(scene) for k, part in owners.items()} for group, owners in parts.items()}, scene)


def _quantities(groups: dict[str, dict[int, Any]], scene: ResolvedScene) -> Quantities:
    """Quantities from groups of numbers, where only bodies with a moving frame have the invariants of such a frame."""
    moving = {of: {b: block for b, block in groups[of].items() if block is not None} for of in ("floating", "drag")}
    return Quantities(**{**groups, **moving}, gravity=np.asarray(scene.gravity))


def owners_of(scene: ResolvedScene, numbering: Numbering, affected: Affected | None = None) -> Owners:
    """Owners of a scene's numbers, all or those among some items and markers; looked up once for all numbers of the scene."""
    known = numbering.owners
    if affected not in known:
        known[affected] = _owners_of(scene, numbering, affected)
    found: Owners = known[affected]
    return found


def _owners_of(scene: ResolvedScene, numbering: Numbering, affected: Affected | None) -> Owners:
    def chosen(items: Iterable[Item]) -> list[int]:
        return [k for k, item in enumerate(items) if affected is None or item in affected.items]

    bodies = chosen(("bodies", name) for name in scene.all_bodies())
    return {
        "start": bodies,
        "constant": bodies,
        "floating": bodies,
        "drag": bodies,
        "markers": range(len(numbering.markers)) if affected is None else sorted(affected.markers),
        "joints": chosen(("joints", name) for name in scene.joints),
        "loads": chosen(("loads", name) for name in named_loads(scene)),
        "pressures": chosen(("loads", name) for name, _ in pressures_on_pieces(scene)),
        "curves": chosen(item for item, _ in curves_of(scene)),
    }


def parts_of(scene: ResolvedScene, numbering: Numbering, owners: Owners) -> dict[str, dict[int, ItemPart]]:
    """Parts that some owners have numbers from, by group and number."""
    everybody: Mapping[str, Body] = scene.all_bodies()
    bodies, joints = list(everybody.values()), list(scene.joints.values())
    loads = loads_of(scene) if owners["loads"] else []
    pressures = [pressure for _, pressure in pressures_on_pieces(scene)] if owners["pressures"] else []
    curves = [curve for _, curve in curves_of(scene)] if owners["curves"] else []
    gravity, width = scene.gravity, scene.space.load_parameters
    heavy = tuple(each for each in scene.loads.values() if isinstance(each, UniformGravity))
    part: dict[str, Callable[[int], ItemPart]] = {
        "start": lambda b: ItemPart((bodies[b],), bodies[b].initial_state),
        "constant": lambda b: ItemPart((bodies[b], *heavy), partial(_constant, bodies[b], gravity)),
        "floating": lambda b: ItemPart((bodies[b],), bodies[b].floating),
        "drag": lambda b: ItemPart((bodies[b],), bodies[b].drag),
        "markers": lambda m: _marker(scene, everybody, numbering.markers[m]),
        "joints": lambda j: ItemPart((joints[j],), partial(_rows, joints[j])),
        "loads": lambda k: ItemPart((loads[k],), partial(_parameters, loads[k], width)),
        "pressures": lambda p: _under_pressure(pressures[p], everybody),
        "curves": lambda c: ItemPart((curves[c],), partial(_itself, curves[c])),
    }
    return {group: {k: part[group](k) for k in some} for group, some in owners.items()}


def _constant(body: Body, gravity: np.ndarray, placed: Placed) -> ConstantNumbers:
    return body.constant(placed, gravity)


def _rows(joint: Joint, placed: Placed) -> np.ndarray:
    return np.array(joint.parameters(placed))


def _under_pressure(pressure: Pressure, everybody: Mapping[str, Any]) -> ItemPart:
    body = everybody[pressure.body]
    return ItemPart((pressure, body), partial(_pressure, pressure, body))


def _pressure(pressure: Pressure, body: SpatialFlexible, placed: Placed) -> PressureNumbers:
    return pressure.numbers_on(placed, body)


def _itself(curve: Curve, _: object) -> Curve:
    return curve


def _marker(scene: ResolvedScene, everybody: Mapping[str, Body], grip: tuple[str, ...]) -> ItemPart:
    """Part of one marker, in space with the axes of its component if it has some."""
    body, point = grip[:2]
    if len(grip) == 2:
        return ItemPart((everybody[body],), partial(_placed_marker, everybody[body], point, body, ()))
    group, name = _owner(grip)
    component = getattr(scene, group)[name]
    return ItemPart((everybody[body], component), partial(_placed_marker, everybody[body], point, body, (component.axes,)))


def _placed_marker(
    body: Body, point: str, name: str, axes: tuple[np.ndarray, ...], placed: Placed
) -> MarkerNumbers | SpatialMarkerNumbers:
    return body.marker(placed, point, name, *axes)


def _owner(grip: tuple[str, ...]) -> Item:
    """Group and name of the component whose axes a marker has."""
    group, _, name = grip[2].partition(".") if len(grip) == 3 else ("", "", "")
    return group, name


def loads_of(scene: ResolvedScene) -> list[Load]:
    """Loads of a scene that grip markers, which gravity does not."""
    return list(named_loads(scene).values())


def named_loads(scene: ResolvedScene) -> dict[str, Load]:
    """Loads of a scene that grip markers, by their names."""
    return {name: load for name, load in scene.loads.items() if isinstance(load, Load)}


def pressures_of(scene: ResolvedScene) -> dict[str, Pressure]:
    """Loads on surfaces of flexible bodies, by their names."""
    return {name: load for name, load in scene.loads.items() if isinstance(load, Pressure)}


def pressures_on_pieces(scene: ResolvedScene) -> list[tuple[str, Pressure]]:
    """Pressures as the equations have them: one on every part of a cut body, with the name of the load."""
    return [
        (name, load if piece == load.body else load.model_copy(update={"body": piece}))
        for name, load in pressures_of(scene).items()
        for piece in scene.pieces([load.body])
    ]


def curves_of(scene: ResolvedScene) -> list[tuple[Item, Curve]]:
    """Time curves of joints, then of loads, then of pressures, each with its owner."""
    components: list[tuple[str, Mapping[str, Component]]] = [("joints", scene.joints), ("loads", named_loads(scene))]
    found = [((group, name), component.time_curve) for group, items in components for name, component in items.items()]
    found += [(("loads", name), pressure.curve) for name, pressure in pressures_of(scene).items()]
    return [(item, curve) for item, curve in found if curve is not None]


def _parameters(component: Component, width: int, placed: Placed) -> np.ndarray:
    """A load's parameters, padded with zeros to a width."""
    row = component.parameters(placed)
    if len(row) > width:
        raise InputError(f"a component has {len(row)} parameters, at most {width} are possible: {component!r}.")
    return np.array([*row, *[0.0] * (width - len(row))])


SAME_PLACE = 1e-12
"""Distance of two points, relative to the model size, below which no direction leads from one to the other."""


def check_numbers(scene: ResolvedScene) -> None:
    """Refuse scenes without a moving body, parameters that no body has, and pairs of points without a direction.

    Raises
    ------
    InputError
        Names the path and what would be right.
    """
    if not scene.bodies:
        raise InputError("the scene has no body, so nothing can move. Add one to its table [bodies].")
    for name, body in scene.bodies.items():
        if isinstance(body, ModelBody):
            check_parameters(body.model_values(), scene.model(body.model).nominal, f"bodies.{name}", scene.dimension)
    for user, pair in pairs(scene).items():
        first, second = (np.real(scene.position(point)) for point in pair)
        if np.abs(first - second).max() <= SAME_PLACE * scene.size:
            raise InputError(
                f"{user} leads from point {pair[0]!r} to point {pair[1]!r}, which are at the same place, so it has no direction. "
                "Move one of them."
            )


def pairs(scene: Scene) -> dict[str, tuple[str, str]]:
    """Everything that has a direction from one point to another: rods, distance joints, springs along a line."""
    rods = {f"bodies.{name}": getattr(body, "between", None) for name, body in scene.bodies.items()}
    links = {f"joints.{name}": joint.points for name, joint in scene.joints.items() if isinstance(joint, JointBetweenPoints)}
    springs = {f"loads.{name}": load.points for name, load in scene.loads.items() if isinstance(load, PointSpring)}
    return {user: pair for user, pair in {**rods, **links, **springs}.items() if pair is not None}


def derivatives(scene: ResolvedScene, numbering: Numbering, design: Design, seen: Seen) -> list[Quantities]:
    """Derivative of all numbers by each design variable; curves stay complex, they are differentiated where they are evaluated.

    Only what is written otherwise, or is told something else by the scene, can have a derivative: the other formulas are left out. So are
    those of bodies and markers that have not met a complex number then, which is so whatever the values of the scene's numbers are.
    """
    found = []
    for variable in design:
        moved = scene.moved(variable, 1j * STEP)
        parts = parts_of(moved, numbering, owners_of(moved, numbering, numbering.affected_by(scene, variable.paths)))
        stirred = _stirred(seen, moved)
        groups = {group: {k: part for k, part in owners.items() if stirred(group, k, part)} for group, owners in parts.items()}
        found.append(_rates(made_of(groups, moved), _is_reached))
    return found


def renewed_derivatives(
    scene: ResolvedScene, numbering: Numbering, design: Design, known: Sequence[Quantities], among: Affected
) -> list[Quantities]:
    """Derivatives by each design variable at other numbers of the scene, for the same owners as far as these affect them."""
    found, affected = [], {group: set(owners) for group, owners in owners_of(scene, numbering, among).items()}
    for variable, before in zip(design, known, strict=True):
        moved = scene.moved(variable, 1j * STEP)
        reached = {group: getattr(before, group).keys() & owners for group, owners in affected.items()}
        found.append(_rates(made_of(parts_of(moved, numbering, reached), moved)))
    return found


def _rates(moved: Quantities, wanted: Callable[[str, object], bool] = lambda _group, _part: True) -> Quantities:
    """Derivatives from numbers with a complex step, without those that nobody wants."""
    found: dict[str, Any] = {"gravity": _imag(moved.gravity)}
    for group in GROUPS:
        given = getattr(moved, group)
        kept = {k: part for k, part in given.items() if wanted(group, part)} if given else {}
        found[group] = kept if group == "curves" else {k: _imag(part) for k, part in kept.items()}
    return Quantities(**found)


def _is_reached(group: str, part: Any) -> bool:
    """Whether any number is complex, even with a zero imaginary part, or could be at other numbers of the scene."""
    if isinstance(part, tuple):
        return any(_is_reached(group, each) for each in part)
    return group in OPEN or isinstance(part, Curve) or np.iscomplexobj(part)


def _stirred(seen: Seen, moved: ResolvedScene) -> Callable[[str, int, ItemPart], bool]:
    """Test whether the numbers of an item can be others in a scene of which other numbers are `moved`."""
    same: dict[Any, bool] = {}

    def unchanged(question: Question) -> bool:
        if question not in same:
            same[question] = answers_alike(seen.scene, moved, question)
        return same[question]

    def stirred(group: str, owner: int, part: ItemPart) -> bool:
        before = seen.parts[group][owner].written
        written = len(before) == len(part.written) and all(map(is_, before, part.written))
        return not (written and all(map(unchanged, seen.asked[group, owner])))

    return stirred


def _imag(value):
    if isinstance(value, tuple):
        items = map(_imag, value)
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return value if np.asarray(value).dtype.kind == "i" else np.imag(value) / STEP  # places stay what they are
