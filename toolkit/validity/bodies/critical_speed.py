"""Bodies that spin: the critical speed of linear FFRF, equilibria that forget a spin, and steps that turn a body far.

The critical speed of a flexible body that spins: linear FFRF lacks centrifugal stiffening and diverges beyond it.

In a frame that spins at omega about an axis the linear body feels K q_f - omega^2 C q_f, with the mass C that moves across the axis (in
the plane all of it): it is stable as long as this matrix is positive definite, that is, as omega is below the lowest frequency of such
motions of the body held by its frame.

    C = sum_a Q[a, a] - sum_ab n_a n_b Q[a, b]        elastic rows and columns, n: unit vector of the axis in the body

Of a body that its spin stiffens, sum_ab n_a n_b S[a, b] is taken from it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from toolkit.components.bodies.body import Body
from toolkit.components.bodies.model_body import ModelBody
from toolkit.components.loads.bushing import Bushing
from toolkit.description.description import InSpace
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.reduced_model.parts import stiffness_of_spin
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene
from toolkit.solvers.start.start_velocities import carried_along, project_velocities, written_velocities
from toolkit.system.solution import Solution, deforming, flexible_body, poses_at, spins_of
from toolkit.system.system import System

FAST_SPIN_PART = 0.5
"""Part of its critical speed from which on a spin may be why a run failed."""


def spinning_bodies(scene: ResolvedScene) -> list[str]:
    """Names of the flexible bodies whose frame can turn."""
    return [name for name, body in deforming(scene).items() if body.turns]


def critical_speed(scene: ResolvedScene, body: str, axis: np.ndarray | None = None, stiffened: bool = True) -> float:
    """The speed of the body's frame, in rad/time, beyond which the linear body is unstable.

    Parameters
    ----------
    axis : direction (3,) in the axes of the reduced model, of a body in space; by default that of a turning frame, or of the angular
        velocity at the start, or the most critical of the three axes of the model
    stiffened : whether with the stiffening that the body asks for
    """
    given = [axis] if axis is not None else _likely_axes(scene, body)
    return min(_critical(scene, body, each, stiffened) for each in given)


def _critical(scene: ResolvedScene, body: str, axis: np.ndarray, stiffened: bool) -> float:
    stiffness, mass = _scaled(scene, body, axis, stiffened)
    last = len(mass) - 1  # the largest eigenvalue of K^-1 C is exact, where the smallest of C^-1 K would drown in round-off
    largest = float(scipy.linalg.eigh(mass, stiffness, eigvals_only=True, subset_by_index=[last, last])[0])
    return float(1 / np.sqrt(largest)) if largest > 0 else np.inf


def _likely_axes(scene: ResolvedScene, body: str) -> list[np.ndarray]:
    found = flexible_body(scene, body)
    if found.only_axis is not None:
        return [found.only_axis]
    spin = np.real(found.start_spin)
    return [spin] if np.any(spin) else list(np.eye(3))


def too_fast_at_start(scene: ResolvedScene) -> Iterator[tuple[str, float, float]]:
    """Bodies that the scene starts beyond their critical speed, how fast, and the critical speed about that axis."""
    for body in spinning_bodies(scene):
        spin = np.real(flexible_body(scene, body).start_spin)
        if not _stable(scene, body, spin):
            yield body, float(np.linalg.norm(spin)), critical_speed(scene, body, spin)


def too_fast_in_motion(solution: Solution) -> Iterator[tuple[str, float, float]]:
    """Bodies that exceed their critical speed where they spin fastest, with that speed and the critical one about the axis then."""
    scene = solution.system.scene
    for body in spinning_bodies(scene):
        spins = spins_of(solution, body)
        spin = spins[first_largest(np.linalg.norm(spins, axis=1))]
        if not _stable(scene, body, spin):
            yield body, float(np.linalg.norm(spin)), critical_speed(scene, body, spin)


def fast_bodies(solution: Solution) -> list[str]:
    """Flexible bodies whose frame spins with `FAST_SPIN_PART` of its critical speed or more at any time."""
    scene = solution.system.scene
    spins = {body: spins_of(solution, body) for body in spinning_bodies(scene)}
    fastest = {body: each[first_largest(np.linalg.norm(each, axis=1))] for body, each in spins.items()}
    return [body for body, spin in fastest.items() if not _stable(scene, body, spin / FAST_SPIN_PART)]


def _stable(scene: ResolvedScene, body: str, spin: np.ndarray) -> bool:
    """Whether K - omega^2 C is positive definite; far cheaper than the critical speed itself."""
    speed = float(np.linalg.norm(spin))
    if speed == 0:
        return True
    stiffness, mass = _scaled(scene, body, spin)
    try:
        np.linalg.cholesky(stiffness - speed**2 * mass)
    except np.linalg.LinAlgError:
        return False
    return True


def _scaled(scene: ResolvedScene, body: str, axis: np.ndarray, stiffened: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """K, scaled to a unit diagonal, and C for an axis of any length in the same scale, (n_f, n_f)."""
    found, unit = flexible_body(scene, body), axis / np.linalg.norm(axis)
    inv, stiffening = found.invariants(scene), found.stiffening(scene)
    mass, stiffness = np.real(inv.mass_across(unit)), np.real(inv.stiffness)
    if stiffened and stiffening is not None:
        mass = mass - stiffness_of_spin(np.real(stiffening), unit)
    scale = 1 / np.sqrt(np.diag(stiffness))
    return scale[:, None] * stiffness * scale, scale[:, None] * mass * scale


SLOW_SPIN_PART = 1e-2
"""Spin, as a part of the lowest circular frequency, up to which it is a remark: gyroscopic forces change frequencies by about this part."""
ZERO_SPIN_PART = 1e-9
"""Spin, as a part of the lowest circular frequency, below which it is round-off."""


@check("spins")
def cautions_of_spin(solution: Solution, frequencies: np.ndarray) -> Iterator[Caution]:
    """Frequencies are those about the equilibrium at rest, but the scene spins.

    Limit: any spin; a doubt from 1 % of the lowest circular frequency on.
    Fix: `ffrf modes --spinning`, if a driver spins the scene as a whole; otherwise read the frequencies off a motion.
    """
    found = fastest_spin(solution)
    if found is None:
        return
    body, spin, when = found
    vibrating = 2 * np.pi * np.abs(frequencies[frequencies != 0])
    lowest = float(vibrating.min(initial=np.inf))
    if spin <= ZERO_SPIN_PART * lowest < np.inf:
        return
    beside = f", {spin / lowest:.2g} of the lowest circular frequency" if np.isfinite(lowest) else ""
    yield cautions_of_spin.caution(
        f"these frequencies are those about the equilibrium at rest, but the scene spins: {body!r} with {spin:.4g} rad/s {when}{beside}. "
        f"Gyroscopic and centrifugal forces are not in them. {cautions_of_spin.fix}",
        doubt=not spin <= SLOW_SPIN_PART * lowest,
    )


def fastest_spin(solution: Solution) -> tuple[str, float, str] | None:
    """Body that turns fastest at the start or, by drivers, at the time of the solution; its rate in rad/time, and when."""
    system = solution.system
    if not written_velocities(system) and not np.any(system.plan.joints.curve >= 0):
        return None
    q, zero = np.concatenate([solution.q[-1], np.zeros(system.n - system.n_q)]), np.zeros(system.n)
    still = np.zeros((system.n, system.n_x))
    time = float(solution.times[-1])
    driven = _velocities(system, q, zero, still, still, time, {})
    candidates = [*_spins(system, *_start(system), "at the start"), *_spins(system, q, driven, f"at t = {time:g}, by its driver")]
    return max(candidates, key=lambda each: each[1], default=None)


def _start(system: System) -> tuple[np.ndarray, np.ndarray]:
    q, v, dq, dv = (np.real(each) for each in system.start())
    v, dv = carried_along(system, q, v, dv, dq)
    return q, _velocities(system, q, v, dq, dv, 0.0, written_velocities(system))


def _velocities(system: System, q, v, dq, dv, time: float, written: dict[int, str]) -> np.ndarray:
    """Velocities that the joints allow; where there are none, those that are given: statics does without."""
    try:
        return np.real(project_velocities(system, q, v, dq, dv, time, written)[0])
    except ToolkitError:
        return v


def _spins(system: System, q: np.ndarray, v: np.ndarray, when: str) -> Iterator[tuple[str, float, str]]:
    for name in system.scene.pieces():
        body, first = system.scene.body(name), system.numbering.first[name]
        at = slice(first, first + body.frame_size)
        rate = body.frame_motion(q[at], v[at]).get("angular_velocity")
        if rate is not None and np.any(rate):
            yield name, float(np.linalg.norm(rate)), when


FULL_TURN = 2 * np.pi
LARGEST_STEP_ANGLE = 0.35 * FULL_TURN
"""Angle in a step: with three steps in a turn nothing is left of a force that turns, and peaks between them are seen (`missed_peaks`)."""
WANTED_STEPS_PER_TURN = 20
"""Steps in a turn that are proposed."""
CENTRED_POINT = 1e-9
"""Way of a point as the body turns by 1 rad, in parts of the model size, that is none."""


@check("turns-in-a-step", (MOTION,))
def turns_in_a_step(solution: Solution) -> Iterator[Caution]:
    """A body turns so far in a step that points and forces on it are seen at a few of its angles.

    Limit: 0.35 turns.
    Fix: the `solver.step` that is told: 20 steps in a turn.

    Steps of other lengths may all see it at the same angles: with a turn in each of them a point on a wheel rests, and a force that
    turns with it is constant. The frames of bodies that move freely in space are not looked at: Newton's iteration fails before.
    """
    numbering, scene = solution.system.numbering, solution.system.scene
    turned = {
        name: _furthest(solution, numbering.first[name] + body.moves)
        for name, body in scene.bodies.items()
        if isinstance(body, Body) and body.turns == 1
    }
    far = {name: angle for name, angle in turned.items() if angle > LARGEST_STEP_ANGLE and _matters(solution, name)}
    if far:
        name = max(far, key=lambda each: far[each])
        steps = np.diff(solution.whole_run).max() * FULL_TURN / (WANTED_STEPS_PER_TURN * far[name])
        yield turns_in_a_step.caution(
            f"{name!r} turns by up to {far[name] / FULL_TURN:.2g} turns in a step (limit {LARGEST_STEP_ANGLE / FULL_TURN:g}). "
            "Points and forces on it are seen at a few of its angles, and other steps may see the same ones. Fix: solver.step = "
            f"{steps:.1g}, "
            f"{WANTED_STEPS_PER_TURN} steps in a turn.",
        )


def _furthest(solution: Solution, coordinate: int) -> float:
    """Largest angle in a step; by its rate where not all states are kept."""
    if solution.run_times is not None:
        return float(np.abs(solution.v[:, coordinate]).max() * np.diff(solution.whole_run).max())
    return float(np.abs(np.diff(np.real(solution.q[:, coordinate]))).max(initial=0.0))


def _matters(solution: Solution, name: str) -> bool:
    """Whether anything depends on how the body stands: it deforms, or something grips it or looks at it beside its centre, or along its
    own axes."""
    system, scene = solution.system, solution.system.scene
    body, first = scene.bodies[name], system.numbering.first[name]
    if isinstance(body, ModelBody) or any(_directed(each, name) for each in _components(scene)):
        return True
    own = [m for m, grip in enumerate(system.numbering.markers) if grip[0] == name]
    states = np.real(solution.q[[0, 0]])
    states[1, first + body.moves] += 1.0
    before, after = poses_at(system, states)[:, own, : scene.dimension]
    return bool(np.abs(after - before).max(initial=0.0) > CENTRED_POINT * scene.size)


def _components(scene: Scene) -> list[InSpace]:
    return [*scene.joints.values(), *scene.loads.values()]


def _directed(component: InSpace, body: str) -> bool:
    """Whether it acts in directions that turn with the body."""
    held = body in (getattr(component, "body", None), *getattr(component, "bodies", ()))
    own_axes = isinstance(component, Bushing) or getattr(component, "frame", "space") == "body"
    return held and (own_axes or len(getattr(component, "axis", None) or ()) == 2)
