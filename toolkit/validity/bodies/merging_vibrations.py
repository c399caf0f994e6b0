"""Vibrations under forces that follow bodies or alternate along them: where two merge, and where they grow.

Vibrations under forces that follow bodies, near the load at which two of them merge and flutter.

What the equations lack inside of a frame, the geometric stiffness G of its elements, is small where frames are many. Near a coalescence it
is not: squares of two frequencies that merge at the load factor m_c differ by c sqrt(m_c - m), so that frequencies, and their derivatives
still more, feel a small change of m_c. With right and left vectors u and w of K u = omega^2 M u, and with u_g and w_g of K + G, the
derivatives by a change of the stiffness and by the load factor are too small by the factors

    c / c_g,  c = |w^T M u| / sqrt(w^T M w  u^T M u),     and    (w_g^T (K_1 + G) u_g / w_g^T M u_g) / (w^T K_1 u / w^T M u)

where K_1 is what the loads add to the stiffness in the equations. Vibrations by K + G are those that are told as true: of Beck's
column, cut into 2 to 16 frames, they are to 2e-3 up to within 0.3 % of the load at which it flutters.

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

from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.flutter import REMEDY, UNSTABLE, fastest_growth, growth_of, may_grow
from toolkit.responses.pencil import Pencil, free_pencil, pencil_change, pencil_of, real_pencil
from toolkit.solvers.free_motions import is_symmetric, is_symmetric_everywhere
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.equations import Inputs
from toolkit.system.solution import Solution, elastic_coordinates
from toolkit.validity.bodies.deformation import LIMIT, divided, flexible_bodies
from toolkit.validity.bodies.geometric_stiffness import Stiffening, stiffening
from toolkit.validity.bodies.led_points import asked_vibrations

ADVISED_EXCESS = 4.0
"""Relative excess for which the number of frames is advised: twice as many frames lack a quarter."""


MERGED_PART = 1e-6
"""Relative imaginary part of the square of a frequency above which two vibrations have merged."""


class Vibrations(NamedTuple):
    """Undamped vibrations of a state, from the slowest on."""

    frequencies: np.ndarray  # (n,) in cycles per time
    conditions: np.ndarray  # (n,) 1 where the stiffness is symmetric, 0 where two merge
    slopes: np.ndarray  # (n,) change of the frequency by the load factor
    merged: np.ndarray  # (n,) whether it has merged with another one


class Merging(NamedTuple):
    """Vibrations by the equations and with the geometric stiffness that they lack, and the body that lacks most."""

    told: Vibrations
    true: Vibrations
    pencil: Pencil  # with what they lack
    body: str


@check("merging-vibrations", STATES, each_design=True)
def merging_vibrations(solution: Solution, lateral: bool = False) -> Iterator[Caution]:
    """The geometric stiffness inside of frames, which the equations lack, changes frequencies, their derivatives or their growth under
    forces that follow bodies.

    Limit: 5 %.
    Fix: more frames, or more elements to cut into frames.

    Parameters
    ----------
    lateral
        Whether derivatives are asked for that the solution does not hold.
    """
    found = None if solution.steps or solution.spins or not may_grow(solution) else _found(solution)
    if found is None:
        return
    told, grows = fastest_growth(solution), growth_of(solution, found.pencil)
    if told and grows and told.doubtful and abs(told.s.real / grows.s.real - 1) > LIMIT:
        yield merging_vibrations.caution(_faster(found, grows.s) + _remedy(solution, found))
    elif grows and grows.doubtful and not (told and told.doubtful):
        lacking = f" These equations, which lack the geometric stiffness inside of the frames of {found.body}, do not show it."
        yield Caution(UNSTABLE, f"{grows.told('equilibrium')}{REMEDY}{lacking} {_remedy(solution, found)}")
    paths = [path for each in solution.system.design.variables for path in each.paths]
    of_loads = any(path.startswith("loads.") for path in paths) if paths else True if lateral else None
    yield from merging_of(solution, asked_vibrations(solution), of_loads)


@check("merging-vibrations")
def merging_of(solution: Solution, asked: Mapping[str, int], of_loads: bool | None = None) -> Iterator[Caution]:
    """Doubts about vibrations of an equilibrium under forces that follow bodies.

    Parameters
    ----------
    asked
        Vibrations by what they are called, and their numbers from the slowest on.
    of_loads
        Whether their derivatives are asked for by numbers of loads among others; None where no derivatives are.
    """
    found = None if solution.steps or solution.spins or not asked or not may_grow(solution) else _found(solution)
    if found is None:
        return
    numbers = {name: k - 1 for name, k in asked.items() if k <= len(found.told.frequencies)}
    of_frequency = {name: found.told.frequencies[k] / found.true.frequencies[k] - 1 for name, k in numbers.items()}
    merged = [name for name, k in numbers.items() if found.true.merged[k] and not found.told.merged[k]]
    differentiated = {name: k for name, k in numbers.items() if of_loads is not None and name not in merged}
    of_slope = {name: _times(found, k, bool(of_loads)) for name, k in differentiated.items()}
    wrong = [
        f"{name} is {abs(part):.1%} too {'high' if part > 0 else 'low'}"
        for name, part in of_frequency.items()
        if abs(part) > LIMIT
    ]
    wrong += [f"derivatives of {name} are {_size(part)}" for name, part in of_slope.items() if abs(part - 1) > LIMIT]
    wrong += [f"{name} has merged with another one" for name in merged]
    if wrong:
        yield merging_of.caution(
            f"the geometric stiffness inside of the frames of {found.body}, which these equations lack, is felt by vibrations under forces "
            f"that follow bodies, most where two of them are about to merge (flutter): {', '.join(wrong)}. {_remedy(solution, found)}",
        )


def _faster(found: Merging, s: complex) -> str:
    return (
        f"with the geometric stiffness inside of the frames of {found.body}, which these equations lack, what grows does so like "
        f"exp({s.real:.4g} t), with {s.imag / (2 * np.pi):.4g} cycles per time. "
    )


def _remedy(solution: Solution, found: Merging) -> str:
    return f"Fix: {divided(solution.system.scene, found.body, ADVISED_EXCESS)}."


def _size(part: float) -> str:
    return f"{part:.3g} times as large as they should be" if abs(part) < 1 / LIMIT else "many times too large"


def _times(found: Merging, k: int, of_loads: bool) -> float:
    """Ratio of the derivatives of a frequency by the equations to true ones, where it is furthest from one."""
    told, true = found.told, found.true
    parts = [told.frequencies[k] and true.conditions[k] * true.frequencies[k] / (told.conditions[k] * told.frequencies[k])]
    if of_loads and true.slopes[k]:
        parts.append(told.slopes[k] / true.slopes[k])
    return float(parts[first_largest(np.abs(np.array(parts) - 1))])


def _found(solution: Solution) -> Merging | None:
    """Vibrations with and without the missing geometric stiffness; None where the stiffness is symmetric or complete."""
    if Merging not in solution.known:
        known = {body: law for body in flexible_bodies(solution.system.scene) if (law := stiffening(solution.system.scene, body))}
        solution.known[Merging] = _compared(solution, known) if known else None
    found: Merging | None = solution.known[Merging]
    return found


def _compared(solution: Solution, known: Mapping[str, Stiffening]) -> Merging | None:
    system, n_q = solution.system, solution.system.n_q
    pencil = real_pencil(pencil_of(solution))
    if is_symmetric_everywhere(pencil.stiffness[:n_q, :n_q]):
        return None
    unloaded = replace(solution, multipliers=np.zeros_like(solution.multipliers))
    bare = real_pencil(pencil_of(unloaded, system.inputs(solution.times[-1], LEVELS, 0.0))).stiffness
    more, lost = np.zeros_like(pencil.stiffness), {}
    for body, law in known.items():
        where = elastic_coordinates(solution, body)
        elastic = np.real(solution.q[-1, where])
        more[where, where] = np.asarray(law.matrix(elastic) @ np.eye(len(elastic)))
        lost[body] = law.softening(elastic)
    names = list(lost)
    worst = names[first_largest(np.array(list(lost.values())))]
    true = pencil._replace(stiffness=pencil.stiffness + more)
    of_loads = pencil.stiffness - bare
    told = _vibrations(solution, pencil, of_loads)
    return Merging(told, _vibrations(solution, true, of_loads + more), true, getattr(system.scene.body(worst), "whole", worst))


def _vibrations(solution: Solution, pencil: Pencil, of_loads: np.ndarray) -> Vibrations:
    system = solution.system
    Z, reduced = free_pencil(system.weights[: system.n_q], pencil)
    forces = Z.T @ of_loads[: system.n_q, : system.n_q] @ Z
    squares, left, right = scipy.linalg.eig(reduced.stiffness, reduced.mass, left=True, right=True)
    frequencies = np.abs(np.imag(np.sqrt(-squares + 0j))) / (2 * np.pi)
    order = np.argsort(frequencies, kind="stable")
    frequencies, u, w = frequencies[order], right[:, order], left[:, order].conj()
    inert = [np.abs(np.sum(a * (reduced.mass @ b), axis=0)) for a, b in ((w, u), (w.conj(), w), (u.conj(), u))]
    with np.errstate(all="ignore"):
        slopes = np.real(np.sum(w * (forces @ u), axis=0) / np.sum(w * (reduced.mass @ u), axis=0)) / (8 * np.pi**2 * frequencies)
        conditions = inert[0] / np.sqrt(inert[1] * inert[2])
    merged = np.abs(np.imag(squares)) > MERGED_PART * np.abs(squares)
    return Vibrations(frequencies, np.nan_to_num(conditions), np.nan_to_num(slopes), merged[order])


LEAST_CROSSINGS = 6
"""Number of times that forces cross their mean, below which they do not alternate."""
LEAST_ALTERNATION = 0.2
"""Part of the stiffness that alternates, times how often it crosses its mean, below which nothing grows by more than a quarter."""
LARGEST_MOVE = 0.1
"""Largest move of coordinates, relative to the model size or in rad, where vibrations about the start hold for the motion."""
SLOWEST_VIBRATIONS = 6
"""Number of the slowest vibrations that are examined."""
RESOLVED_OMEGA_STEP = 1.0
"""Largest omega dt of a vibration that the states of a run still show."""
RESONANT_GROWTH = 2.0
"""Growth of a disturbance over the run above which it is a resonance, and no beat."""
DOUBTED_GROWTH = 100.0
"""Growth above which an exactly straight state is doubted: any imperfection of a real one becomes so many times as large."""
AMPLITUDE_ROUND_OFF = 1e-9
"""Amplitude, relative to the model size, below which a vibration is round-off."""
GROWTH_PARTS = 64
"""Number of parts of the run at whose ends the growth is evaluated."""


class AlternatingVibration(NamedTuple):
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
    shown = found.found > AMPLITUDE_ROUND_OFF and found.true > LIMIT * _moved(solution)
    if shown and found.true > (1 + LIMIT) * found.found:
        times = found.true / found.found
        yield parametric_resonance.caution(
            f"{what}. These equations, which lack the geometric stiffness inside of frames, do not show it. With it this vibration is up "
            f"to {times:.3g} times as large. Fix: {divided(solution.system.scene, found.body, 4.0)}.",
        )
    elif not shown and found.growth > DOUBTED_GROWTH:
        yield parametric_resonance.caution(
            f"{what}, and hardly anything sets it off here, because all is straight. What is real is not. Fix: disturb it, with a small "
            "force across it at the start, to see how large it becomes.",
        )


def resonance(solution: Solution) -> Resonance | None:
    """Vibration that grows most by alternating forces; None where none alternates, or nothing grows."""
    if not solution.steps or len(solution.times) < LEAST_CROSSINGS or _moved(solution) > LARGEST_MOVE:
        return None
    scene = solution.system.scene
    known = {body: law for body in flexible_bodies(scene) if (law := stiffening(scene, body))}
    alternating = [body for body, law in known.items() if _alternates(solution, body, law)]
    if not alternating:
        return None
    body = getattr(scene.body(alternating[0]), "whole", alternating[0])
    found = [each for vibration in _alternating(solution, known) if (each := _resonance(solution, body, vibration))]
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
    return crossings >= LEAST_CROSSINGS and crossings * half > LEAST_ALTERNATION


def _moved(solution: Solution) -> float:
    """Largest move of any coordinate, relative to the model size or in rad."""
    n_b = solution.system.n_b
    moved = np.ptp(np.real(solution.q[:, :n_b]), axis=0) * solution.system.weights[:n_b]
    return float(moved.max(initial=0.0))


def _alternating(solution: Solution, known: Mapping[str, Stiffening]) -> Iterator[AlternatingVibration]:
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
    slow = np.flatnonzero((squares > 0) & (squares * step**2 < RESOLVED_OMEGA_STEP**2))[:SLOWEST_VIBRATIONS]
    for k in slow:
        yield _vibration(solution, start, known, pencil, float(squares[k]), Z @ shapes[:, k])


def _vibration(
    solution: Solution, start: Solution, known: Mapping[str, Stiffening], pencil: Pencil, square: float, shape: np.ndarray
) -> AlternatingVibration:
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
    return AlternatingVibration(float(np.sqrt(square)), damping, of_equations, lacking, (course[0], course[1], course[2]), size)


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


def _resonance(solution: Solution, body: str, each: AlternatingVibration) -> Resonance | None:
    """Growth of one vibration; None where nothing grows."""
    growth = _growth(solution.times, each, each.known + each.lacking)
    if growth < RESONANT_GROWTH:
        return None
    found = float(np.abs(each.course[0]).max()) * each.size
    return Resonance(body, each.omega / (2 * np.pi), growth, found, _course(solution.times, each) * each.size)


def _steps(times: np.ndarray, each: AlternatingVibration, change: np.ndarray) -> np.ndarray:
    """Transition matrices (n_t - 1, 2, 2) of (omega y, y') over each step, with the stiffness in its middle."""
    step, half = np.diff(times), each.damping / 2
    stiffness = each.omega**2 + (change[1:] + change[:-1]) / 2
    rate = np.sqrt(stiffness - half**2 + 0j)
    rate = np.where(rate == 0, 1e-30, rate)
    cosine, sine = np.real(np.cos(rate * step)), np.real(np.sin(rate * step) / rate)
    rows = [[cosine + half * sine, each.omega * sine], [-stiffness * sine / each.omega, cosine - half * sine]]
    found: np.ndarray = np.moveaxis(np.exp(-half * step) * np.array(rows), -1, 0)
    return found


def _growth(times: np.ndarray, each: AlternatingVibration, change: np.ndarray) -> float:
    """Largest growth of the root of the energy of any disturbance from the start on."""
    parts = np.array_split(_steps(times, each, change), GROWTH_PARTS)
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


def _course(times: np.ndarray, each: AlternatingVibration) -> float:
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
