"""Vibrations under forces that follow bodies, near the load at which two of them merge and flutter.

What the equations lack inside of a frame, the geometric stiffness G of its elements, is small where frames are many. Near a coalescence it
is not: squares of two frequencies that merge at the load factor m_c differ by c sqrt(m_c - m), so that frequencies, and their derivatives
still more, feel a small change of m_c. With right and left vectors u and w of K u = omega^2 M u, and with u_g and w_g of K + G, the
derivatives by a change of the stiffness and by the load factor are too small by the factors

    c / c_g,  c = |w^T M u| / sqrt(w^T M w  u^T M u),     and    (w_g^T (K_1 + G) u_g / w_g^T M u_g) / (w^T K_1 u / w^T M u)

where K_1 is what the loads add to the stiffness in the equations. Vibrations by K + G are those that are told as true: of Beck's
column, cut into 2 to 16 frames, they are to 2e-3 up to within 0.3 % of the load at which it flutters.
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
from toolkit.responses.pencil import Pencil, free_pencil, pencil_of, real_pencil
from toolkit.solvers.free_motions import is_symmetric_everywhere
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.lines_on_bodies import asked_vibrations
from toolkit.validity.bodies.compressed.geometric_stiffness import Stiffening, stiffening
from toolkit.validity.bodies.cut.more_frames import divided
from toolkit.validity.bodies.deformation import LIMIT, flexible_bodies

ENOUGH = 4.0
"""Relative excess for which the number of frames is advised: twice as many frames lack a quarter."""


MERGED = 1e-6
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
    return f"Fix: {divided(solution.system.scene, found.body, ENOUGH)}."


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
    merged = np.abs(np.imag(squares)) > MERGED * np.abs(squares)
    return Vibrations(frequencies, np.nan_to_num(conditions), np.nan_to_num(slopes), merged[order])
