"""Vibrations across forces that alternate along a body: near 2 omega / k they grow, whatever excites them (parametric resonance).

A vibration omega of a scene that hardly moves otherwise, with the mass-normalised shape phi, has the stiffness of Hill's equation,

    y'' + d y' + (omega^2 + k_1(t) + k_2(t)) y = f(t),     k_2 = sum_e N_e(t) phi^T Q_e phi

where k_1 is what the equations know of forces and k_2 what they lack inside of frames (`geometric_stiffness`). Where N alternates by
eps omega^2 cos 2 omega t, y grows like exp((eps omega / 4 - d / 2) t) (Mathieu). Here the equation is solved over all states of a run: its
fundamental matrix tells how much any disturbance grows, and with f(t) of the motion as it was found, what y had been.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy

from toolkit.equations.equations import Inputs
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.pencil import Pencil, free_pencil, pencil_change, pencil_of, real_pencil
from toolkit.solvers.free_motions import is_symmetric
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening, stiffening
from toolkit.validity.bodies.cut.more_frames import divided
from toolkit.validity.bodies.deformation import LIMIT, flexible_bodies

ALTERNATES = 6
"""Number of times that forces cross their mean, below which they do not alternate."""
ENOUGH = 0.2
"""Part of the stiffness that alternates, times how often it crosses its mean, below which nothing grows by more than a quarter."""
STILL = 0.1
"""Largest move of coordinates, relative to the model size or in rad, where vibrations about the start hold for the motion."""
SLOWEST = 6
"""Number of the slowest vibrations that are examined."""
RESOLVED = 1.0
"""Largest omega dt of a vibration that the states of a run still show."""
GROWS = 2.0
"""Growth of a disturbance over the run above which it is a resonance, and no beat."""
SETS_OFF = 100.0
"""Growth above which an exactly straight state is doubted: any imperfection of a real one becomes so many times as large."""
STRAIGHT = 1e-9
"""Amplitude, relative to the model size, below which a vibration is round-off."""
PARTS = 64
"""Number of parts of the run at whose ends the growth is evaluated."""


class Vibration(NamedTuple):
    """One vibration of a scene, with its stiffness and its course over all states (n_t,)."""

    omega: float
    damping: float  # d
    known: np.ndarray  # k_1
    lacking: np.ndarray  # k_2
    course: tuple[np.ndarray, np.ndarray, np.ndarray]  # y, y', y'' as they were found
    size: float  # the largest entry of phi, in parts of the model size or rad


class Resonance(NamedTuple):
    """Growth of one vibration by alternating forces along a body."""

    body: str
    frequency: float
    growth: float  # of any disturbance
    found: float  # the largest vibration in parts of the model size or rad, by the equations
    true: float


@check("parametric-resonance", STATES, each_design=True)
def parametric_resonance(solution: Solution) -> Iterator[Caution]:
    """Forces along a body alternate so that vibrations across it grow, and the motion does not show it.

    Limit: growth to twice, and by 5 % of the vibration; growth by 100 where hardly anything sets it off.
    Fix: more frames, and a small force across the body at the start.
    """
    found = resonance(solution)
    if found is None:
        return
    what = (
        f"forces along {found.body} alternate so that vibrations across it with {found.frequency:.4g} cycles per time grow (parametric "
        f"resonance): a disturbance becomes {found.growth:.3g} times as large in this motion"
    )
    shown = found.found > STRAIGHT and found.true > LIMIT * _moved(solution)
    if shown and found.true > (1 + LIMIT) * found.found:
        times = found.true / found.found
        yield parametric_resonance.caution(
            f"{what}. These equations, which lack the geometric stiffness inside of frames, do not show it. With it this vibration is up "
            f"to {times:.3g} times as large. Fix: {divided(solution.system.scene, found.body, 4.0)}.",
        )
    elif not shown and found.growth > SETS_OFF:
        yield parametric_resonance.caution(
            f"{what}, and hardly anything sets it off here, because all is straight. What is real is not. Fix: disturb it, with a small "
            "force across it at the start, to see how large it becomes.",
        )


def resonance(solution: Solution) -> Resonance | None:
    """Vibration that grows most by alternating forces; None where none alternates, or nothing grows."""
    if not solution.steps or len(solution.times) < ALTERNATES or _moved(solution) > STILL:
        return None
    scene = solution.system.scene
    known = {body: law for body in flexible_bodies(scene) if (law := stiffening(scene, body))}
    alternating = [body for body, law in known.items() if _alternates(solution, body, law)]
    if not alternating:
        return None
    body = getattr(scene.body(alternating[0]), "whole", alternating[0])
    found = [each for vibration in _vibrations(solution, known) if (each := _resonance(solution, body, vibration))]
    return found[first_largest(np.array([each.growth for each in found]))] if found else None


def _alternates(solution: Solution, body: str, law: Stiffening) -> bool:
    """Whether axial forces take stiffness and give it back, often and by enough.

    For a part, the whole that it was cut from counts, by the square of the number of parts.
    """
    part = np.real(solution.q[:, elastic_coordinates(solution, body)]) @ (law.compliances @ law.forces)
    scene = solution.system.scene
    whole = getattr(scene.body(body), "whole", None)
    count = sum(getattr(scene.body(each), "whole", "") == whole for each in scene.pieces()) if whole else 1
    half = count**2 * np.ptp(part) / 2
    above = part > part.mean()
    crossings = int(np.count_nonzero(above[1:] != above[:-1])) if half > 0 else 0
    return crossings >= ALTERNATES and crossings * half > ENOUGH


def _moved(solution: Solution) -> float:
    """Largest move of any coordinate, relative to the model size or in rad."""
    n_b = solution.system.n_b
    moved = np.ptp(np.real(solution.q[:, :n_b]), axis=0) * solution.system.weights[:n_b]
    return float(moved.max(initial=0.0))


def _vibrations(solution: Solution, known: Mapping[str, Stiffening]) -> Iterator[Vibration]:
    """Slowest vibrations about the first state."""
    system, n_q = solution.system, solution.system.n_q
    first = {name: getattr(solution, name)[:1] for name in ("times", "q", "v", "a", "multipliers")}
    start = replace(solution, **first)
    pencil = real_pencil(pencil_of(start))
    Z, reduced = free_pencil(system.weights[:n_q], pencil)
    if not is_symmetric(reduced.stiffness):
        return
    try:
        squares, shapes = scipy.linalg.eigh(*((each + each.T) / 2 for each in (reduced.stiffness, reduced.mass)))
    except scipy.linalg.LinAlgError:
        return
    step = float(np.diff(solution.times).max())
    slow = np.flatnonzero((squares > 0) & (squares * step**2 < RESOLVED**2))[:SLOWEST]
    for k in slow:
        yield _vibration(solution, start, known, pencil, float(squares[k]), Z @ shapes[:, k])


def _vibration(
    solution: Solution, start: Solution, known: Mapping[str, Stiffening], pencil: Pencil, square: float, shape: np.ndarray
) -> Vibration:
    system, n_q = solution.system, solution.system.n_q
    lacking, framed = np.zeros(len(solution.times)), np.ones(n_q, bool)
    for body, law in known.items():
        where = elastic_coordinates(solution, body)
        framed[where] = False
        turns = law.behind.shapes @ shape[where]
        ends = turns[law.behind.forms.dofs]
        softness = np.einsum("ep,epq,eq->e", ends, law.behind.stiffening[:, 0], ends)
        lacking += np.real(solution.q[:, where]) @ (law.forces.T @ softness)
    row = pencil.mass[:n_q, :n_q] @ shape
    course = tuple((np.real(each) - np.real(solution.q[0] if each is solution.q else 0.0)) @ row for each in _states(solution))
    damping = float(shape @ pencil.damping[:n_q, :n_q] @ shape)
    of_equations = _known(solution, start, shape) if framed.any() or len(system.plan.joints.curve) else 0.0 * lacking
    size = float(np.abs(system.weights[:n_q] * shape).max())
    return Vibration(float(np.sqrt(square)), damping, of_equations, lacking, (course[0], course[1], course[2]), size)


def _states(solution: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return solution.q, solution.v, solution.a


def _known(solution: Solution, start: Solution, shape: np.ndarray) -> np.ndarray:
    """Stiffness k_1 (n_t,) that the equations know, by its change with coordinates, joint forces, and loads."""
    system, n_q = solution.system, solution.system.n_q
    whole = np.append(shape, np.zeros(system.n - n_q))
    by_z = np.real(pencil_change(start, 0.0, whole, whole, damped=False)[0])
    z = np.column_stack([np.real(solution.q), np.real(solution.multipliers)])
    found: np.ndarray = (z - z[0]) @ by_z
    curves, inputs = np.real(system.curves(solution.times)[0]), system.inputs(float(solution.times[0]), LEVELS)

    def stiffness(of: Inputs) -> float:
        return float(np.real(whole @ pencil_of(start, of).stiffness @ whole))

    before = stiffness(inputs)
    for k in np.unique(system.plan.loads.curve[system.plan.loads.curve >= 0]):
        more = inputs.curves.copy()
        more[k, 0] += 1.0
        found += (curves[:, k, 0] - curves[0, k, 0]) * (stiffness(inputs._replace(curves=more)) - before)
    return found


def _resonance(solution: Solution, body: str, each: Vibration) -> Resonance | None:
    """Growth of one vibration; None where nothing grows."""
    growth = _growth(solution.times, each, each.known + each.lacking)
    if growth < GROWS:
        return None
    found = float(np.abs(each.course[0]).max()) * each.size
    return Resonance(body, each.omega / (2 * np.pi), growth, found, _course(solution.times, each) * each.size)


def _steps(times: np.ndarray, each: Vibration, change: np.ndarray) -> np.ndarray:
    """Transition matrices (n_t - 1, 2, 2) of (omega y, y') over each step, with the stiffness in its middle."""
    step, half = np.diff(times), each.damping / 2
    stiffness = each.omega**2 + (change[1:] + change[:-1]) / 2
    rate = np.sqrt(stiffness - half**2 + 0j)
    rate = np.where(rate == 0, 1e-30, rate)
    cosine, sine = np.real(np.cos(rate * step)), np.real(np.sin(rate * step) / rate)
    rows = [[cosine + half * sine, each.omega * sine], [-stiffness * sine / each.omega, cosine - half * sine]]
    found: np.ndarray = np.moveaxis(np.exp(-half * step) * np.array(rows), -1, 0)
    return found


def _growth(times: np.ndarray, each: Vibration, change: np.ndarray) -> float:
    """Largest growth of the root of the energy of any disturbance from the start on."""
    parts = np.array_split(_steps(times, each, change), PARTS)
    total, largest = np.eye(2), 1.0
    for part in parts:
        total = _product(part) @ total
        largest = max(largest, float(np.linalg.norm(total, 2)))
    return largest


def _product(matrices: np.ndarray) -> np.ndarray:
    """Product of matrices (n, 2, 2), the last one on the left, by halves."""
    while len(matrices) > 1:
        if len(matrices) % 2:
            matrices = np.concatenate([matrices, np.eye(2)[None]])
        matrices = matrices[1::2] @ matrices[::2]
    return matrices[0] if len(matrices) else np.eye(2)


def _course(times: np.ndarray, each: Vibration) -> float:
    """Largest y under the force that excites the motion as it was found."""
    y, rate, acceleration = each.course
    force = acceleration + each.damping * rate + (each.omega**2 + each.known) * y
    steps, change = _steps(times, each, each.known + each.lacking), each.known + each.lacking
    stiffness = each.omega**2 + (change[1:] + change[:-1]) / 2
    rest = (force[1:] + force[:-1]) / 2 / stiffness * each.omega  # where a constant force would hold omega y
    first, second, largest = float(each.omega * y[0]), float(rate[0]), 0.0
    for ((a, b), (c, d)), at in zip(steps.tolist(), rest.tolist(), strict=True):
        first, second = at + a * (first - at) + b * second, c * (first - at) + d * second
        largest = max(largest, first, -first)
    return largest / each.omega
