"""What a run tells of single loads, joints and responses: creeping friction, springs, bushings, cams."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.components.joints.cam import OnCam
from toolkit.components.joints.kernels.profile import SEAM_OVERLAP
from toolkit.components.joints.profile import CLOSED_TOLERANCE, FULL_TURN
from toolkit.components.joints.rows import Form
from toolkit.components.loads.bushing import SpatialBushing
from toolkit.components.loads.controllers import DistanceControlled
from toolkit.components.loads.friction import Friction
from toolkit.components.loads.springs import PointSpring
from toolkit.foundation.errors import quoted
from toolkit.foundation.kernel import plain
from toolkit.foundation.near_ties import spread
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import MOTION, REST, STATES, Caution, check
from toolkit.responses.marker_formula import MarkerMotion
from toolkit.responses.response import Response
from toolkit.scene.scene import Scene
from toolkit.system.numbering import grips_of
from toolkit.system.quantities import named_loads
from toolkit.system.solution import Solution, poses_at
from toolkit.system.system import System, compile_scene

FRICTION_INSTANTS = 2000
"""Instants, evenly spread over the motion."""
CREEP_ROUND_OFF = 1e-9
"""Part of what the width itself would creep that is round-off of a scene at rest."""

MOST_UNKNOWNS = 500
"""Unknowns of the largest scene whose frictions are asked for their rates, by dense matrices."""
ACCELERATIONS = np.array([1.0, 0.0, 0.0])
"""Weights of the constraints' accelerations, velocities and positions."""


@check("friction-width", (MOTION,))
def creeping_friction(solution: Solution) -> Iterator[Caution]:
    """What the width of a regularised friction is, for how long the motion was slower, and how far it crept meanwhile.

    Limit: any friction.
    Fix: a smaller width if the creep matters.
    """
    scene = solution.system.scene
    for k, (name, load) in enumerate(named_loads(scene).items()):
        if not isinstance(load, Friction):
            continue
        steps = np.array(spread(len(solution.times) - 1, FRICTION_INSTANTS))
        rates, times, width = np.abs(_rates(solution, name, k, steps)), solution.times[steps], float(np.real(load.width))
        slow = rates < width
        part = _integral(times, slow.astype(float)) / (times[-1] - times[0])
        label, crept = unit(scene.units, load.rate), _integral(times, np.where(slow, rates, 0))
        crept = crept if crept > CREEP_ROUND_OFF * width * (times[-1] - times[0]) else 0.0
        way = f"{crept:.3g} {label.partition('/')[0]}"
        said = f"Slower than that, {part:.0%} of the time, it lets creep: by {way}. {creeping_friction.fix}"
        yield creeping_friction.caution(
            f"loads.{name} is friction regularised by velocity, with a width of {width:g} {label}. "
            f"{said if np.any(slow) else 'Nothing was slower than that at any time.'}",
            doubt=False,
        )


@check("friction-at-rest", (REST,))
def friction_at_rest(solution: Solution) -> Iterator[Caution]:
    """Friction that is regularised by velocity holds nothing in an equilibrium.

    Limit: any friction.
    Fix: a motion that comes to rest.
    """
    for name, load in solution.system.scene.loads.items():
        if isinstance(load, Friction) and load.level:
            yield friction_at_rest.caution(
                f"loads.{name} is friction regularised by velocity, which holds nothing in an equilibrium. True friction would hold the "
                f"scene somewhere short of this one. Vibrations feel a damper of level / width. {friction_at_rest.fix}",
                doubt=False,
            )


def told_frictions(system: System, q: np.ndarray, step: float) -> str:
    """What to know of frictions whose width sets the step, in a position (n,); empty where steps resolve them all."""
    scene, found = system.scene, []
    frictions = {name: load for name, load in scene.loads.items() if isinstance(load, Friction) and np.real(load.width) > 0}
    if not frictions or system.n > MOST_UNKNOWNS:
        return ""
    narrow = _damping(system, q)
    for name, load in frictions.items():
        width = float(np.real(load.width))
        without = compile_scene(scene.with_number(f"loads.{name}.width", width / CREEP_ROUND_OFF))
        fastest = np.abs(_eigenvalues(system, q, narrow - _damping(without, q))).max(initial=0.0)
        if fastest * step > 1:
            label = unit(scene.units, load.rate)
            found.append(
                f"Below its width of {width:g} {label} loads.{name} stops what moves in {1 / fastest:.2g} s, which steps of {step:g} do "
                f"not resolve: widen it to {width * fastest * step:.2g} {label}, or take steps of {1 / fastest:.1g}."
            )
    return " ".join(found)


def _damping(system: System, q: np.ndarray) -> np.ndarray:
    """Derivatives (n, n) of the forces by the velocities, at rest."""
    rest = np.zeros(system.n)
    return np.real(system.dense(system.evaluate(system.inputs(0.0, ACCELERATIONS), q, rest, rest).A_v))


def _eigenvalues(system: System, q: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Rates at which a damping matrix (n, n) stops the bodies, as their joints let them move; none where those are redundant."""
    rest = np.zeros(system.n)
    inertia = np.real(system.dense(system.evaluate(system.inputs(0.0, ACCELERATIONS), q, rest, rest).I_acc))
    try:
        return np.linalg.eigvals(np.linalg.solve(inertia, damping))
    except np.linalg.LinAlgError:
        return np.zeros(0)


def _rates(solution: Solution, name: str, k: int, steps: np.ndarray) -> np.ndarray:
    """g' at some steps, (n_steps,)."""
    system, load, found = solution.system, named_loads(solution.system.scene)[name], np.zeros(len(steps))
    motion, numbers = MarkerMotion.of(system, grips_of(f"loads.{name}", load)), np.real(system.plan.loads.parameter[k])
    assert isinstance(load, Friction)
    for n, step in enumerate(steps):
        a, b = motion.at(solution, int(step))
        w = np.real(np.concatenate([a.rate, b.rate]))
        slope, bend = np.zeros(len(w)), np.zeros((len(w), len(w)))
        plain(load.measured())(np.real(np.concatenate([a.y, b.y, numbers])), slope, bend)
        found[n] = slope @ w
    return found


def _integral(times: np.ndarray, values: np.ndarray) -> float:
    return float(np.sum(np.diff(times) * (values[1:] + values[:-1]) / 2))


EXAMINED_INSTANTS = 500
"""Instants, evenly spread over a motion, that are examined; between two in which a spring points the other way every step is."""


@check("spring-through-zero", (MOTION,))
def springs_through_zero(solution: Solution) -> Iterator[Caution]:
    """A spring passes length zero, where its force jumps to the other side.

    Limit: any.
    Fix: one end aside, a relaxed length of zero, or a force without a jump.

    Its force jumps by 2 k l_0 there. Values follow the jump to first order in the step; derivatives hold it at its time, and miss how the
    design moves it.
    """
    scene, last = solution.system.scene, len(solution.times) - 1
    springs = {
        name: load
        for name, load in scene.loads.items()
        if isinstance(load, DistanceControlled)
        or (isinstance(load, PointSpring) and load.stiffness and np.real(load.parameters(scene)[2]) > 0)
    }
    if not springs:
        return
    some = np.array(spread(last, EXAMINED_INSTANTS))
    for (name, spring), turns in zip(springs.items(), _turns(solution, list(springs.values()), some), strict=True):
        closer = (np.arange(some[at], some[at + 1] + 1) for at in turns)
        found = next((int(every[at[0]]) for every in closer if len(at := _turns(solution, [spring], every)[0])), None)
        if found is not None:
            yield springs_through_zero.caution(
                f"loads.{name} passes length zero at t = {solution.times[found]:.6g}. Its force, which points along it, jumps to the other "
                "side there. Values follow the jump to first order in the step; derivatives miss how the design moves it. "
                f"{springs_through_zero.fix}",
            )


def _turns(solution: Solution, springs: list[PointSpring | DistanceControlled], steps: np.ndarray) -> list[np.ndarray]:
    """Places in `steps`, for each spring, after which the vector from end to end points against the one before."""
    system = solution.system
    ends = np.array([[system.numbering.marker(grip) for grip in each.grips] for each in springs])
    poses = poses_at(system, solution.q[steps])[:, :, : system.scene.dimension]
    vectors = poses[:, ends[:, 0]] - poses[:, ends[:, 1]]
    against = np.einsum("tsi,tsi->ts", vectors[:-1], vectors[1:]) < 0
    return [np.flatnonzero(each) for each in against.T]


SMALL = np.radians(30)
"""Angle at which its sine, which the torque grows with, is off by 4.5 %."""


@check("bushing-turned-far", STATES)
def bushings_turned_far(solution: Solution) -> Iterator[Caution]:
    """A bushing in space is turned by more than a small rotation, for which its torques are defined.

    Limit: 30 degrees, where they are off by 4.5 %.
    Fix: a universal or revolute joint with rotational springs.
    """
    system = solution.system
    bushings = {name: load for name, load in system.scene.loads.items() if isinstance(load, SpatialBushing)}
    bushings = {name: load for name, load in bushings.items() if any((*load.rotational_stiffness, *load.rotational_damping))}
    if not bushings:
        return
    states = np.atleast_2d(np.real(solution.q))
    poses = poses_at(system, states[spread(len(states) - 1, EXAMINED_INSTANTS)])
    for name, load in bushings.items():
        first, second = (system.numbering.marker(grip) for grip in load.grips)
        cosine = (np.einsum("tk,tk->t", poses[:, first, 3:], poses[:, second, 3:]) - 1) / 2
        largest = float(np.arccos(np.clip(cosine.min(), -1, 1)))
        if largest > SMALL:
            yield bushings_turned_far.caution(
                f"loads.{name} turns by up to {np.degrees(largest):.0f} degrees. A bushing in space has the torques of a small rotation: "
                f"at 30 degrees its stiffness acts 4.5 % too little, its damping 25 %. {bushings_turned_far.fix}",
            )


STEP = 1e-30


@check("cam-opened", STATES)
def opened_profiles(solution: Solution) -> Iterator[Caution]:
    """A variable of the design moves the end of a cam's closed curve away from its beginning, and the cam has passed both.

    Limit: any.
    Fix: one variable for the numbers of both ends.

    The follower would jump there, and its derivative by that variable misses it.
    """
    system = solution.system
    cams = {name: joint for name, joint in system.scene.joints.items() if isinstance(joint, OnCam)}
    for name in cams:
        opening = [each.name for each in system.design if _opens(system.scene, name, list(each.paths), list(each.factors))]
        if opening and _passes(solution, name):
            yield opened_profiles.caution(
                f"{', '.join(opening)} would open the curve of joints.{name}, whose end is its beginning after a turn, and the cam has "
                f"passed it. The follower would jump there, which no derivative knows. {opened_profiles.fix}",
            )


def _opens(scene: Scene, name: str, paths: list[str], factors: list[float]) -> bool:
    """Whether a variable moves value or slope at the end of a curve apart from those at its beginning."""
    moved = scene
    for path, factor in zip(paths, factors, strict=True):
        if path.startswith(f"joints.{name}.curve."):
            moved = moved.with_number(path, moved.number(path) + 1j * STEP * factor)
    joint = moved.joints[name]
    assert isinstance(joint, OnCam)
    slopes = np.imag(joint.curve.evaluate(np.linspace(0, FULL_TURN, 721)))[:, :2]
    return bool(np.any(np.abs(slopes[-1] - slopes[0]) > CLOSED_TOLERANCE * np.abs(slopes).max(axis=0)))


def _passes(solution: Solution, name: str) -> bool:
    """Whether the angle of the cam leaves the turn that it begins in."""
    system = solution.system
    joint = system.scene.joints[name]
    sine, cosine = joint.constraint(system.scene)[0].forms[-2], joint.constraint(system.scene)[0].forms[-3]
    markers = [system.numbering.marker(grip if joint.axes is None else (*grip, f"joints.{name}")) for grip in joint.grips]
    states = np.atleast_2d(np.real(solution.q))
    poses = [_vectors(pose) for pose in poses_at(system, states[spread(len(states) - 1, EXAMINED_INSTANTS)])[:, markers]]
    angles = np.unwrap([np.arctan2(_value(sine, vectors), _value(cosine, vectors)) for vectors in poses])
    return bool(angles.min() < -SEAM_OVERLAP or angles.max() >= FULL_TURN - SEAM_OVERLAP)


def _vectors(pose: np.ndarray) -> np.ndarray:
    """Position and axes of both markers, and in the plane the difference of both positions behind them, see `joints.poses`."""
    if pose.shape[1] > 3:
        return pose.reshape(8, 3)
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    own = np.stack([pose[:, :2], np.column_stack([c, s]), np.column_stack([-s, c])], axis=1).reshape(6, 2)
    return np.vstack([own, own[0] - own[3]])


def _value(form: Form, vectors: np.ndarray) -> float:
    """Value of a form of products of vectors."""
    return float(sum(np.real(value) * (vectors[i] @ vectors[k]) for i, k, value in form.pairs))


@check("left-out", (MOTION,))
def left_out(solution: Solution) -> Iterator[Caution]:
    """Responses of an equilibrium were left out of a motion.

    Limit: any.
    Fix: `ffrf statics`; or `when = "end"`, for frequencies and damping about the last state.
    """
    asked = solution.system.scene.responses.items()
    names = [name for name, each in asked if isinstance(each, Response) and each.needs_rest]
    if names:
        which = f"{quoted(names)} {'is a response' if len(names) == 1 else 'are responses'}"
        yield left_out.caution(
            f"{which} of an equilibrium, and left out of this motion. {left_out.fix}",
            doubt=False,
        )
