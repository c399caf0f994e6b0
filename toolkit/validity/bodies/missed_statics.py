"""Stress, strain energy and small displacements of the shapes that a reduced basis leaves out, under a run's forces.

Deflection of reduced parts by the forces of a run in shapes that were left out.

The full scene is put into the states of the run, where its equations are not in balance, inertia included. What is left of the forces would
move the parts by delta (see `full_scene`): their part in the motion as long as none of these shapes vibrates.

Its reduced model tells what unit loads at rest do in these shapes (`LeftOutShapes`): with the forces c at its points, and what its weight
and its inertia pull at every mass,

    missed energy = c^T C c / 2,    missed stress = B R F c,    missed displacements of its points = C c

which is all that they do as long as none of them vibrates, and as joints bear what they bear.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from toolkit.components.bodies.model_body import ModelBody
from toolkit.description.description import Registered
from toolkit.description.design import BodyPoint
from toolkit.foundation.kinematics.orientation import axes_along
from toolkit.foundation.value_types import Record
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.reduced_model.cut_part import ChainPart
from toolkit.reduced_model.design_point import DesignPoint
from toolkit.reduced_model.parts import LeftOutShapes
from toolkit.responses.energy import StrainEnergy
from toolkit.responses.local_stress import LocalStress
from toolkit.responses.motion import Displacement, Rotation
from toolkit.responses.over_time import OverTime
from toolkit.responses.response import Instant
from toolkit.responses.stress import StressResponse, point_stress
from toolkit.scene.scene import Scene
from toolkit.system.equations import Inputs
from toolkit.system.solution import Solution, deforming, design_point, elastic_coordinates, flexible_body
from toolkit.validity.bodies.beam_assumptions import FREE_FALL_DIFFERENCE, pull_of_frame
from toolkit.validity.bodies.deformation import LIMIT, UNDEFORMED_PART, largest_displacement, largest_instants, undeformed_places
from toolkit.validity.bodies.full_scene import FullScene, ReducedPart, full_scene_of
from toolkit.validity.bodies.geometric_stiffness import wrenches_at_points

if TYPE_CHECKING:
    from toolkit.scene.resolution import ResolvedScene

INSTANTS = 50
"""Number of states of a run that are examined, equally far apart."""


@dataclass(frozen=True)
class LeftOut:
    """Largest displacement and stress, at any of the instants, that the left-out shapes of one body would add."""

    displacement: float  # of a node, in parts of the largest displacement of the body
    stress: float  # in parts of its largest stress


def left_out_shapes(solution: Solution) -> dict[str, LeftOut]:
    """Displacement and stress that every body lacks whose parts do not keep all coordinates, by name."""
    if LeftOut not in solution.known:
        full = full_scene_of(solution)
        forces = np.zeros(0) if full is None else _unbalanced(solution, full)
        parts = {} if full is None else full.parts
        solution.known[LeftOut] = {name: _of_body(solution, name, [*own.values()], forces) for name, own in parts.items()}
    found: dict[str, LeftOut] = solution.known[LeftOut]
    return found


@check("left-out-shapes", STATES)
def shapes_missed(solution: Solution) -> Iterator[Caution]:
    """Doubts about bodies whose parts keep too few shapes."""
    for name, found in left_out_shapes(solution).items():
        if not max(found.displacement, found.stress) <= LIMIT:
            modes = solution.system.scene.bodies[name].modes_per_frame  # type: ignore[attr-defined]
            yield shapes_missed.caution(
                f"the parts of {name} keep {modes} {'mode' if modes == 1 else 'modes'} each: those that were left out would move it by "
                f"{found.displacement:.1%} of its largest displacement and change its stress by {found.stress:.1%} of the largest (limit "
                f"{LIMIT:.0%}). Write a larger bodies.{name}.modes_per_frame, or leave it out to keep all coordinates.",
            )


def shapes_measured(solution: Solution) -> Record:
    """Body -> displacement and stress that its parts lack, as a record."""
    return {name: asdict(each) for name, each in left_out_shapes(solution).items()}


def _unbalanced(solution: Solution, full: FullScene) -> np.ndarray:
    """Residual forces at the coordinates of the full scene in states of the run, (n_t, n_q)."""
    n = np.unique(np.linspace(0, len(solution.times) - 1, INSTANTS).round().astype(int))
    system, n_q = full.system, full.system.n_q
    states: np.ndarray = np.zeros((3, len(n), system.n))
    for state, known in zip(states, (solution.q, solution.v, solution.a), strict=True):
        state[:, :n_q] = known[n] @ full.expanded.T
    states[2, :, n_q:] = solution.multipliers[n]
    inertia = not (solution.options or solution.system.scene.solver).quasi_static
    curves, curves_x = system.curves(solution.times[n])
    left = np.zeros((len(n), n_q))
    for k, (q, v, acc) in enumerate(zip(*states, strict=True)):
        terms = system.evaluate(Inputs(curves[k], curves_x[k], 1.0, np.zeros(3), inertia, False), q, v, acc, linearize=False)
        left[k] = (terms.inertial + terms.applied)[:n_q]
    return left


def _of_body(solution: Solution, name: str, parts: list[ReducedPart], forces: np.ndarray) -> LeftOut:
    scene = solution.system.scene
    body: Any = scene.bodies[name]
    moved = [(each.part, each.moved(forces[:, each.rows])) for each in parts]
    displacement, size = largest_displacement(solution, name), np.ptp(undeformed_places(scene, name), axis=0).max()
    away = max(_farthest(part, elastic) for part, elastic in moved)
    stress = _largest_stress(body.stress_operator(scene), solution.q[:, elastic_coordinates(solution, name)])
    changed = max(_largest_stress(part.invariants.stress_operator, elastic) for part, elastic in moved)
    return LeftOut(away / displacement if displacement > UNDEFORMED_PART * size else 0.0, changed / stress if stress > 0 else 0.0)


def _farthest(part: ChainPart, elastic: np.ndarray) -> float:
    """Largest displacement of a node by elastic coordinates (n_t, n_f)."""
    moves = (elastic @ part.recovery[:, 1:].T).reshape(len(elastic), -1, part.per_node)[:, :, : part.nodes.shape[1]]
    return float(np.sqrt((moves * moves).sum(axis=2)).max())


def _largest_stress(operator: np.ndarray, elastic: np.ndarray) -> float:
    """Largest stress by elastic coordinates (n_t, n_f)."""
    return float(np.abs(elastic @ operator.reshape(-1, operator.shape[-1]).T).max(initial=0.0))


class MovedPoint(NamedTuple):
    """A point that a response looks at, and the flexible body that carries it."""

    response: Any  # a displacement or rotation
    body: str  # flexible
    interface: str

    def missed(self, solution: Solution, moves: np.ndarray, instants: np.ndarray) -> np.ndarray:
        """Change of the response (n_t,) by the interface point's displacement and rotation (n_t, 3 or 6) in the model's axes."""
        scene, d = solution.system.scene, solution.system.scene.dimension
        written: Any = flexible_body(scene, self.body)
        axes = written.poses(np.real(solution.q[instants][:, solution.coordinates(self.body)]))[1]
        shift, turn = np.einsum("tij,tj->ti", axes, moves[:, :d]), moves[:, d:]
        turn = np.einsum("tij,tj->ti", axes, turn) if d == 3 else turn
        if isinstance(self.response, Rotation):
            along = np.ones(1) if d == 2 else axes_along(np.array(self.response.axis))[:, 2]
            found: np.ndarray = turn @ along
            return found
        return self._along(shift)

    def _along(self, shift: np.ndarray) -> np.ndarray:
        if self.response.component == "magnitude":
            length: np.ndarray = np.linalg.norm(shift, axis=1)
            return length
        component: np.ndarray = shift[:, "xyz".index(self.response.component)]
        return component


def moved_points(scene: ResolvedScene) -> Iterator[tuple[str, MovedPoint]]:
    """Displacements and rotations that responses ask for, of points that a flexible body carries, by name."""
    for name, response in scene.responses.items():
        if isinstance(response, Displacement | Rotation):
            ((body, point),) = response.grips(scene)
            turns = isinstance(response, Rotation)
            for carrier, at in [(body, point), *(_fixed_to(scene, body) if turns else ())]:
                place = scene.points.get(at)
                if isinstance(place, BodyPoint) and place.body == carrier and _carries_alone(scene, carrier):
                    yield name, MovedPoint(response, carrier, place.interface)


def _fixed_to(scene: Scene, body: str) -> Iterator[tuple[str, str]]:
    """Body and point that a rigid body is fixed to, if one joint holds it."""
    mine = [joint for joint in scene.joints.values() if body in joint.bodies]
    if len(mine) == 1 and mine[0].kind == "rigid":
        yield from (grip for grip in mine[0].grips if grip[0] != body)


def _carries_alone(scene: Scene, body: str) -> bool:
    """Whether a grounded flexible body has joints only with bodies that nothing else holds."""
    written = scene.bodies.get(body)
    if not isinstance(written, ModelBody) or written.frame_size:
        return False
    others = [other for joint in scene.joints.values() if body in joint.bodies for other in joint.bodies if other != body]
    return all(other in scene.bodies and sum(other in joint.bodies for joint in scene.joints.values()) == 1 for other in others)


EXAMINED_INSTANTS = 24
"""Number of instants, evenly spread over a motion, that are examined beside those of the largest deformation."""
MOST_DEFORMED = 16
"""Number of instants of the largest deformation."""
UNMOVED_PART = 1e-12
"""Rotation, and displacement relative to the model size, up to which it is round-off."""


@check("left-out-shapes", STATES)
def missed_statics(solution: Solution) -> Iterator[Caution]:
    """Doubts about stress, strain energy and displacements that responses ask for and left-out shapes would change."""
    asked = _asked(solution)
    known = _left_out(solution, asked) if asked else {}
    if not known:
        return
    instants = _instants(solution, asked, [*known])
    bodies = {name: _Reduced(solution, name, left_out, instants) for name, left_out in known.items()}
    parts = {name: _part(solution, name, each, bodies, instants) for name, each in asked.items() if _concerned(each, bodies)}
    high = {name: part for name, part in sorted(parts.items(), key=lambda each: -each[1]) if part > LIMIT}
    if high:
        about = {body: each for name in high for body, each in _concerned(asked[name], bodies).items()}
        yield missed_statics.caution(_told(solution, high, [*about]))


def _told(solution: Solution, parts: dict[str, float], about: list[str]) -> str:
    one = len(about) == 1
    modes_alone = any("interface" not in design_point(solution.system.scene, each).model.left_out for each in about)
    other = ', or of kind "craig-bampton", whose shapes know forces at interface points' if modes_alone else ""
    return (
        f"{'the basis' if one else 'the bases'} of {' and '.join(about)} {'leaves' if one else 'leave'} out shapes that forces at points, "
        f"weight and inertia act on: without them {', '.join(f'{name} is off by about {part:.0%}' for name, part in parts.items())}. "
        f"Build {'it' if one else 'them'} with more modes{other}."
    )


Asked: TypeAlias = StrainEnergy | LocalStress | StressResponse | MovedPoint
"""What responses look at that left-out shapes change."""


def _asked(solution: Solution) -> dict[str, Asked]:
    """Response -> what it looks at, for stress, strain energy, or points that reduced bodies carry."""
    looked_at = {name: _source(response) for name, response in solution.system.scene.responses.items()}
    known: dict[str, Asked] = {
        name: each for name, each in looked_at.items() if isinstance(each, StrainEnergy | LocalStress | StressResponse)
    }
    return known | dict(moved_points(solution.system.scene))


def _source(response: Registered) -> Registered:
    return _source(response.source) if isinstance(response, OverTime) else response


def _concerns(asked: Asked, body: str) -> bool:
    return asked.body in (None, body)


def _left_out(solution: Solution, asked: Mapping[str, Asked]) -> dict[str, LeftOutShapes]:
    """Left-out shapes of the bodies that responses concern, as far as their models hold them."""
    scene, found = solution.system.scene, {}
    for name in filter(scene.bodies.__contains__, deforming(scene)):
        if any(_concerns(each, name) for each in asked.values()) and not design_point(scene, name).model.keeps_all:
            left_out = design_point(scene, name, "left_out_shapes").model.left_out_shapes
            if left_out is not None:
                found[name] = left_out
    return found


def _instants(solution: Solution, asked: Mapping[str, Asked], bodies: list[str]) -> np.ndarray:
    """Numbers of the instants that are examined, in order of time."""
    last = len(solution.times) - 1
    responses = [solution.system.scene.responses[name] for name in asked]
    own = [each.step(solution) for each in responses if isinstance(each, Instant)]
    largest = [largest_instants(np.real(solution.q[:, elastic_coordinates(solution, name)]), MOST_DEFORMED) for name in bodies]
    return np.unique(np.concatenate([np.linspace(0, last, EXAMINED_INSTANTS).astype(int), np.array(own, int), *largest]))


class _Reduced:
    """One body at the instants that are examined: what its basis tells, and what it misses."""

    def __init__(self, solution: Solution, body: str, left_out: LeftOutShapes, instants: np.ndarray) -> None:
        self.design, self.left_out = design_point(solution.system.scene, body), left_out
        self.elastic = np.real(solution.q[instants][:, elastic_coordinates(solution, body)])
        self.loads = amplitudes_of_loads(solution, body, instants)
        self.softer, self.stressed = softer_and_stressed(self.design)
        self.points, self.per_point = _points(solution, body), len(solution.system.scene.space.wrench)
        self.scene = solution.system.scene

    @cached_property
    def energies(self) -> np.ndarray:
        """Strain energy that the basis tells, and the true one, (2, n_t)."""
        stiffness = np.real(self.design.value("stiffness"))
        forms = (self.elastic, stiffness), (self.loads, self.softer * self.left_out.compliance)
        told, missed = (np.einsum("ti,ij,tj->t", x, form, x) / 2 for x, form in forms)
        return np.stack([told, told + missed])

    def is_round_off(self, asked: Asked, size: float) -> bool:
        """Whether a size is round-off: of weight that inertia cancels, as in free fall, or of no motion at all."""
        if isinstance(asked, MovedPoint):
            return size <= UNMOVED_PART * (1.0 if isinstance(asked.response, Rotation) else self.scene.size)
        first, gravity = len(self.points) * self.per_point, np.real(self.scene.gravity)
        weight = np.zeros(len(self.left_out))
        weight[first : first + len(gravity)] = FREE_FALL_DIFFERENCE * np.linalg.norm(gravity)
        if isinstance(asked, StrainEnergy):
            return size <= float(weight @ np.abs(self.left_out.compliance) @ weight)
        return size <= float((np.abs(self.left_out.stress_operator) @ weight).max(initial=0.0))

    @cached_property
    def stresses(self) -> np.ndarray:
        """Stress that the basis tells, and the true one, (2, n_t, n_stress)."""
        operator = np.real(self.design.value("stress_operator")).reshape(-1, self.elastic.shape[1])
        told = self.elastic @ operator.T
        return np.stack([told, told + self.stressed * self.loads @ self.left_out.stress_operator.T])

    def moves(self, interface: str) -> np.ndarray:
        """Missed displacement and rotation of an interface point, (n_t, 3 or 6), in the axes of the model."""
        first, size = self.points.index(interface), self.per_point
        return self.softer * self.loads @ self.left_out.compliance[:, size * first : size * (first + 1)]


def softer_and_stressed(design: DesignPoint) -> tuple[float, float]:
    """Ratio of the body's compliance to that at its nominal design, and ratio of its stress; of kept shapes, on the whole."""
    nominal = design.model.invariants
    stiffness, operator = (np.real(design.value(name)) for name in ("stiffness", "stress_operator"))
    softer = float(np.mean(np.diag(nominal.stiffness) / np.diag(stiffness)))
    size = np.linalg.norm(nominal.stress_operator)
    return softer, softer * float(np.linalg.norm(operator) / size) if size else 0.0


def amplitudes_of_loads(solution: Solution, body: str, instants: np.ndarray) -> np.ndarray:
    """Amplitudes c (n_t, n) of the unit loads, in the order of `LeftOutShapes`."""
    wrenches = wrenches_at_points(solution, body, instants)
    none = np.zeros((len(instants), len(solution.system.scene.space.wrench)))
    alike, by_place, by_shape = pull_of_frame(solution, body, instants)
    design = design_point(solution.system.scene, body)
    heavier = float(np.real(design.value("mass")) / design.model.invariants.mass)
    pulls = (heavier * each for each in (alike, by_place.reshape(len(instants), -1), by_shape))
    return np.concatenate([*(wrenches.get(name, none) for name in _points(solution, body)), *pulls], axis=1)


def _points(solution: Solution, body: str) -> list[str]:
    return sorted(design_point(solution.system.scene, body, "interfaces").model.interfaces or {})


def _concerned(asked: Asked, bodies: dict[str, _Reduced]) -> dict[str, _Reduced]:
    return {name: each for name, each in bodies.items() if _concerns(asked, name)}


def _part(solution: Solution, name: str, asked: Asked, bodies: dict[str, _Reduced], instants: np.ndarray) -> float:
    """Relative error of a response, against the largest value over the run of what it looks at."""
    mine = [*_concerned(asked, bodies).values()]
    told, true = _moves(solution, asked, mine[0], instants) if isinstance(asked, MovedPoint) else _curves(solution, asked, mine)
    size = float(np.abs(true).max())
    if all(each.is_round_off(asked, size) for each in mine):
        return 0.0
    response = solution.system.scene.responses[name]
    if isinstance(response, Instant) or getattr(response, "when", "all") == "end":
        n = int(np.searchsorted(instants, response.step(solution))) if isinstance(response, Instant) else -1
        return float(np.abs(true[n] - told[n])) / size
    return float(np.abs(size - np.abs(told).max())) / size


def _moves(solution: Solution, asked: MovedPoint, body: _Reduced, instants: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Told and true values (n_t,) of a displacement or rotation."""
    look = asked.response.instants(solution)
    told = np.real([look(int(n)).value for n in instants])
    return told, told + asked.missed(solution, body.moves(asked.interface), instants)


def _curves(
    solution: Solution, asked: StrainEnergy | LocalStress | StressResponse, bodies: list[_Reduced]
) -> tuple[np.ndarray, np.ndarray]:
    """Told and true values (n_t,) of the stress or strain energy that a response looks at."""
    if isinstance(asked, StrainEnergy):
        told, true = np.sum([each.energies for each in bodies], axis=0)
        return told, true
    told, true = bodies[0].stresses
    if isinstance(asked, LocalStress):
        rows = asked.rows(solution.system.scene)
        told, true = (
            np.array([asked.reduced(point_stress(each[:, None]))[0] for each in both[:, rows]]) for both in (told, true)
        )
        return told, true
    told, true = (asked.signed(each[:, :, None]).max(axis=1) for each in (told, true))
    return told, true
