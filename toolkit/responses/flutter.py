"""Whether small motions about an equilibrium or a steady spin grow: statics and a frequency alone do not tell.

Whether small motions about an equilibrium or a steady spin grow: statics alone do not see what flutters.

Statics follow a path of positive stiffness, so that an equilibrium whose stiffness is symmetric and whose dampers take energy is stable.
Forces that follow a body, moments about fixed axes and controllers make the stiffness unsymmetric, and vibrations may grow, damped ones
before undamped ones. Of such an equilibrium alone the vibrations are computed,

    (s^2 M + s C + K) u = 0,     Re s > e (|s|^2 |w|^T |M| |u| + |s| |w|^T |C| |u| + |w|^T |K| |u|) / |w^T (2 s M + C) u|

with the round-off of each one by itself: near a coalescence, where two frequencies merge, w^T (2 s M + C) u vanishes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy

from toolkit.foundation.verdict import Caution
from toolkit.responses.pencil import REPEATED_ROOTS, Pencil, find_vibration, free_pencil, pencil_of, real_pencil, spinning_pencil
from toolkit.responses.vibration import DampingRatio, Frequency, OfVibration, any_pencil_of, free_spin
from toolkit.solvers.free_motions import ROUND_OFF, UNSYMMETRIC_PART, all_roots, is_symmetric_everywhere, refined
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.solvers.static.static_matrix import StaticArray, largest_entry, whole_array
from toolkit.system.solution import Solution
from toolkit.system.system import System

if TYPE_CHECKING:
    from toolkit.foundation.value_types import Scalar

    pass

UNSTABLE = "unstable-vibration"
"""Code of what is told."""
LEAST_GROWTH = 1e-5
"""Growth, a part of |s|, below which a vibration counts as one that stays: it needs ten thousand cycles to become twice as large."""
GROWTH_HELD_BY_DAMPING = 0.01
"""Growth, a part of |s|, up to which the damping of what is real holds a vibration of a scene that has none: a square shaft under any
torque about a fixed axis flutters without damping (Nicolai), by 0.6 % where its shear stress is 60 MPa, and stands still in fact."""
SLOWEST_VIBRATIONS = 60
"""Number of undamped vibrations that are looked at: what flutters is slow, and the cost goes with the cube of the number."""


class Growth(NamedTuple):
    """A vibration, or a motion that runs away, about an equilibrium, with its right and left vectors (n_q,)."""

    s: complex
    right: np.ndarray
    left: np.ndarray
    damped: bool  # whether the scene has any damping

    @property
    def part(self) -> float:
        """Growth rate Re s / |s|, as a part of the critical damping."""
        return self.s.real / abs(self.s)

    @property
    def doubtful(self) -> bool:
        """Whether a real structure would grow too: the scene has dampers, or the growth exceeds what small damping holds."""
        return self.damped or self.part > GROWTH_HELD_BY_DAMPING

    def told(self, state: str) -> str:
        """Message about how the vibration or disturbance grows; `state` is what the message calls the state."""
        if self.s.imag <= REPEATED_ROOTS * abs(self.s):
            return f"a small disturbance of this {state} grows like exp({self.s.real:.4g} t), so that nothing comes to rest here."
        larger = np.exp(2 * np.pi * self.s.real / self.s.imag)
        held = "" if self.doubtful else f" The scene has no damping, and {self.part:.1%} of the critical one would hold it."
        return (
            f"a vibration with {self.s.imag / (2 * np.pi):.4g} cycles per time about this {state} grows like "
            f"exp({self.s.real:.4g} t): after each cycle it is {larger:.4g} times as large, so that nothing comes to rest here (flutter)."
            f"{held}"
        )


REMEDY = (
    " The response damping-ratio tells how fast. Take less of the load, the gain or the speed that drives it, or change the dampers: a "
    "little damping inside may make it flutter sooner."
)


def unstable_vibrations(solution: Solution, doubt: bool = True) -> Iterator[Caution]:
    """Warn of the fastest growing small motion about an equilibrium or a steady spin, with its dampers; never about a motion."""
    grows = None if solution.steps else fastest_growth(solution)
    if grows is not None:
        yield Caution(UNSTABLE, grows.told("spin" if solution.spins else "equilibrium") + REMEDY, doubt and grows.doubtful)


def fastest_growth(solution: Solution) -> Growth | None:
    """The motion about an equilibrium or a steady spin that grows fastest for its size |s|; None if none grows, or if none can."""
    if Growth not in solution.known:
        solution.known[Growth] = growth_of(solution, _pencil(solution)) if may_grow(solution) else None
    found: Growth | None = solution.known[Growth]
    return found


def may_grow(solution: Solution) -> bool:
    """Whether the stiffness is unsymmetric, or dampers may give energy: quick, and of sparse matrices where they are large."""
    if may_grow not in solution.known:
        keeps = _keeps_spinning if solution.spins else _is_conservative
        system = solution.system
        moves = system.n_b + system.n_q + len(system.plan.dropped) > system.n  # more coordinates than constraints
        solution.known[may_grow] = moves and not keeps(solution)
    found: bool = solution.known[may_grow]
    return found


def _pencil(solution: Solution) -> Pencil:
    return real_pencil(spinning_pencil(solution) if solution.spins else pencil_of(solution))


def _keeps_spinning(solution: Solution) -> bool:
    """Whether the stiffness in the frame that spins is symmetric and positive, and dampers take energy: gyroscopic forces do no work."""
    n_q, pencil = solution.system.n_q, _pencil(solution)
    if not is_symmetric_everywhere(pencil.stiffness[:n_q, :n_q]):
        return False
    reduced = free_pencil(solution.system.weights[:n_q], pencil)[1]
    try:
        np.linalg.cholesky((reduced.stiffness + reduced.stiffness.T) / 2)
    except np.linalg.LinAlgError:
        return False
    damping = (reduced.damping + reduced.damping.T) / 2
    return bool(np.linalg.eigvalsh(damping).min(initial=0.0) >= -UNSYMMETRIC_PART * np.abs(reduced.damping).max(initial=0.0))


def _is_conservative(solution: Solution) -> bool:
    system = solution.system
    q, acc = np.zeros(system.n), np.zeros(system.n)
    q[: system.n_q], acc[system.n_q :] = np.real(solution.q[-1]), np.real(solution.multipliers[-1])
    terms = system.evaluate(system.inputs(solution.times[-1], LEVELS), q, np.zeros(system.n), acc)
    stiffness, damping = (_of_coordinates(system, each) for each in (terms.I_q + terms.A_q, terms.A_v))
    return is_symmetric_everywhere(stiffness) and _takes_energy(damping)


def _of_coordinates(system: System, values: np.ndarray) -> StaticArray:
    return whole_array(system, np.real(values))[: system.n_q, : system.n_q]


def _takes_energy(damping: StaticArray) -> bool:
    """Whether no motion gets energy from the dampers; a large sparse matrix is judged by symmetry and diagonal alone."""
    largest = largest_entry(damping)
    if largest == 0:
        return True
    if not is_symmetric_everywhere(damping) or damping.diagonal().min() < -ROUND_OFF * largest:
        return False
    if not isinstance(damping, np.ndarray):
        return True
    size = np.sqrt(np.maximum(damping.diagonal(), ROUND_OFF * largest))
    return bool(np.linalg.eigvalsh(damping / np.outer(size, size))[0] > -UNSYMMETRIC_PART)


def growth_of(solution: Solution, pencil: Pencil) -> Growth | None:
    """Motion that grows fastest for its size, by a pencil about the last state of a solution; None if nothing grows."""
    system = solution.system
    Z, reduced = free_pencil(system.weights[: system.n_q], pencil)
    basis = _slow_motions(Z[system.n_b :], reduced)
    values, left, right = all_roots(*(basis.T @ each @ basis for each in reduced))
    sizes = Pencil(*(np.abs(each[: system.n_q, : system.n_q]) for each in pencil))
    growing, damped = [], bool(np.any(pencil.damping))
    for k in np.flatnonzero((values.real > LEAST_GROWTH / 2 * np.abs(values)) & (values.imag >= 0)):
        with np.errstate(all="ignore"):
            s, u, w = refined(*reduced, values[k], basis @ right[:, k], basis @ left[:, k])
        scale = abs(w @ (2 * s * reduced.mass + reduced.damping) @ u)
        if s.real * scale > max(LEAST_GROWTH * abs(s) * scale, _round_off(sizes, s, np.abs(Z @ u), np.abs(Z @ w))):
            growing.append(Growth(complex(s.real, abs(s.imag)), Z @ u, Z @ w, damped))
    return max(growing, key=lambda each: each.part, default=None)


def _round_off(sizes: Pencil, s: complex, u: np.ndarray, w: np.ndarray) -> float:
    """Round-off of the sum of the pencil's terms along w and u, below which it counts as zero."""
    terms = w @ (abs(s) ** 2 * sizes.mass + abs(s) * sizes.damping + sizes.stiffness) @ u
    return 10 * ROUND_OFF * float(terms)


def _slow_motions(states: np.ndarray, reduced: Pencil) -> np.ndarray:
    """Columns (n, m): the slowest vibrations of the symmetric part, with all states of loads (n_s, n), which have no mass."""
    n = len(reduced.mass)
    if n <= SLOWEST_VIBRATIONS:
        return np.eye(n)
    rows = np.linalg.svd(states)[2] if len(states) else np.eye(n)
    massive = rows[len(states) :].T
    stiffness, mass = (massive.T @ (each + each.T) @ massive for each in (reduced.stiffness, reduced.mass))
    try:
        slow = scipy.linalg.eigh(stiffness, mass, subset_by_index=[0, SLOWEST_VIBRATIONS - 1])[1]
    except scipy.linalg.LinAlgError:
        return np.eye(n)
    return np.column_stack([massive @ slow, rows[: len(states)].T])


GROWTH_TO_REFINE = 1e-4
"""Growth, a part of |s|, from which on a root is found again to all digits: what is below may be round-off of faster ones."""


def growing_vibrations(solution: Solution, values: Mapping[str, Scalar]) -> Iterator[Caution]:
    """Caution for each kind of vibration response whose vibrations grow: a remark where a negative damping ratio says so itself.

    Of an equilibrium at rest it is said whatever is asked for, with its dampers; and of frequencies without them if they alone keep it.
    """
    responses = solution.system.scene.responses
    wanted = {type(each): each for name, each in responses.items() if name in values and isinstance(each, OfVibration)}
    told = any(np.real(value) < 0 for name, value in values.items() if isinstance(responses[name], DampingRatio))
    of_state = list(unstable_vibrations(solution, doubt=not told))
    yield from of_state
    if of_state:
        return
    if not (solution.steps or solution.spins):
        wanted = {kind: each for kind, each in wanted.items() if issubclass(kind, Frequency)}
    if not wanted:
        return
    pencil, weights = any_pencil_of(solution), solution.system.weights[: solution.system.n_q]
    for kind, response in wanted.items():
        grows = _fastest_growth(response, solution, pencil, weights)
        if grows is not None:
            how, larger = _without(kind, solution), np.exp(2 * np.pi * grows.real / grows.imag)
            yield Caution(
                UNSTABLE,
                f"a vibration with {grows.imag / (2 * np.pi):.4g} cycles per time about this state{how} grows: after each cycle it is "
                f"{larger:.4g} times as large, so that nothing comes to rest here. The response damping-ratio tells how fast; add damping, "
                "or take less of the load or the speed that drives it.",
                doubt=issubclass(kind, Frequency) or not told,
            )


def _without(kind: type[OfVibration], solution: Solution) -> str:
    """Words saying that frequencies about an equilibrium at rest are undamped; empty for every other response."""
    return "" if solution.spins or solution.steps or not issubclass(kind, Frequency) else ", without dampers,"


def _fastest_growth(response: OfVibration, solution: Solution, pencil: Pencil, weights: np.ndarray) -> complex | None:
    """Root s of the counted vibration that grows fastest for its frequency; None if none grows."""
    counted = real_pencil(response.counting(solution, pencil))
    roots = response.vibrations(solution, pencil, weights)
    suspects = [k + 1 for k, s in enumerate(roots) if s.real > GROWTH_TO_REFINE * abs(s) and s.imag > REPEATED_ROOTS * abs(s)]
    idle = free_spin(solution) if suspects else None
    found = [find_vibration(weights, counted, number, response.slowness, idle).s for number in suspects]
    growing = [s for s in found if s.real > GROWTH_TO_REFINE * abs(s) and s.imag > REPEATED_ROOTS * abs(s)]
    return max(growing, key=lambda s: s.real / abs(s), default=None)
