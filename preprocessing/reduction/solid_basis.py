"""The basis of a solid: the shapes that were chosen, and their derivatives by what changes the elements and the ties."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csr_array

from preprocessing.reduction.basis import BasisChoice
from preprocessing.reduction.normal_modes import (
    NormalModes,
    check_static_error,
    count_by_frequency,
    refuse_cut_cluster,
    slowest_left_out,
)
from preprocessing.reduction.solid_systems import BasisChange, free_system, held_system
from preprocessing.reduction.sparse_modes import ShiftedSystem, lowest_modes, mode_rates
from preprocessing.reduction.ties import Freedom, NodeTie, chord_turn, supported
from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import Chord


def count_by_static_error(modes: NormalModes, rows: Mapping[str, csr_array], system: ShiftedSystem, largest: float) -> int | None:
    """Smallest number of the modes with a relative static error of at most `largest`; None if these modes are not enough.

        || C - C_k || / || C ||,     C = R K^-1 R^T,  C_k = sum_{j <= k} (R phi_j) (R phi_j)^T / lambda_j

    with the largest singular value as the norm, and every row of R divided by the square root of its own compliance, see
    `normal_modes.static_errors`.

    Raises
    ------
    InputError
        The request is invalid, or no interface point can move.
    """
    check_static_error(largest)
    if not rows:
        raise InputError("a static error needs an interface point that can move: name one away from the clamp.")
    every = sparse.vstack(list(rows.values()), format="csr")
    compliance = every @ system.solve(every.T.toarray())
    scale = 1 / np.sqrt(np.diag(compliance))
    moves = scale[:, None] * (every @ modes.shapes) / np.sqrt(modes.eigenvalues)
    rest = scale[:, None] * compliance * scale
    whole = np.linalg.norm(rest, 2)
    for k, move in enumerate(moves.T, start=1):
        rest = rest - np.outer(move, move)
        if np.linalg.norm(rest, 2) <= largest * whole:
            return k
    return None


LARGEST_FULL = 3000
"""Coordinates of the largest full basis: its dense matrices take some 100 MB."""
CLAMPED_ROWS = 1e-12
"""Largest entry of the rows of a point on the clamp."""
EXTRA_MODES = 4
"""Modes beyond those that are kept: the last ones that Lanczos finds come last."""


@dataclass(frozen=True, eq=False)
class SolidShapes:
    """Shapes Psi of a solid on the independent coordinates, with the system that they solve."""

    columns: np.ndarray  # (n^, n_f)
    words: str
    stiffness: csr_array | None = None  # (n^, n^)
    system: ShiftedSystem | None = None
    modes: NormalModes | None = None
    beyond: NormalModes | None = None  # modes that are left out, as many as were found
    n_held: int = 0  # last coordinates, which the system does not have
    averaged: tuple[str, ...] = ()  # interface points whose rows the system has, in their order
    points: tuple[str, ...] = ()  # interface points with constraint modes, in their order
    of_points: np.ndarray | None = None  # their constraint modes (n^, k) before a chord took some of their motions
    turn: np.ndarray | None = None  # T of `chord_turn`

    @property
    def left_out(self) -> dict[str, float]:
        """Lowest frequency that the shapes leave out, as in `ReducedModel.left_out`."""
        return slowest_left_out(self.beyond.eigenvalues, bool(self.points)) if self.beyond else {}

    def rates(self, change: BasisChange) -> np.ndarray:
        """Derivatives (n^, n_f) by a variable that changes the matrices on the independent coordinates."""
        found = np.zeros_like(self.columns)
        if self.system is None:
            return found
        inside = len(found) - self.n_held
        n_static = self.columns.shape[1] - (self.modes.count if self.modes else 0)
        if n_static and self.of_points is not None and self.turn is not None:
            found[:inside, :n_static] = self._static_rates(self.of_points, change, inside) @ self.turn
            if change.turn is not None:
                found[:, :n_static] += self.of_points @ change.turn
        elif n_static:
            found[:inside, :n_static] = self._static_rates(self.columns[:, :n_static], change, inside)
        if self.modes and self.beyond:
            rates = mode_rates(self.system, self.modes, change.inside(inside), self.beyond)
            found[:inside, n_static:] = self.modes.turned(rates)
        return found

    def _static_rates(self, columns: np.ndarray, change: BasisChange, inside: int) -> np.ndarray:
        """Derivatives of static shapes: du of K du + B^T dp = -dK u - dB^T p, B du = -dB u.

        The coordinates beyond `inside` stay what they are.
        """
        assert self.system is not None
        loads = self.system.loads_of(-(self.stiffness @ columns)[:inside], change.inside(inside))
        below = 0.0 if change.rows is None else -(change.rows @ columns)
        return self.system.solve(-(change.stiffness @ columns)[:inside] - loads, below)


def solid_shapes(
    choice: BasisChoice,
    mass: csr_array,
    stiffness: csr_array,
    motions: np.ndarray,
    places: np.ndarray,
    free: Freedom,
    ties: Mapping[str, NodeTie],
) -> SolidShapes:
    """Shapes of a solid that the basis choice asks for.

    Parameters
    ----------
    mass, stiffness : (n^, n^), on the independent coordinates
    motions : (n^, m), rigid motions of a body that nothing holds
    places : (n^, d), where each coordinate is
    ties : interface points

    Raises
    ------
    InputError
        The choice asks for what the body or its interface points cannot give.
    """
    n = stiffness.shape[0]
    if n == 0:
        raise InputError("the clamp holds all nodes, so that nothing of the body can deform. Clamp fewer, or take a rigid body.")
    if free.stiff:
        raise InputError(
            f"the rigid tie of interface point {free.rigid[0]!r} holds all nodes, so that nothing of the body can deform. Tie fewer, or "
            "take a rigid body."
        )
    if choice.chord is not None and choice.kind in ("full", "eigenmodes"):
        raise InputError(
            f'a solid on a chord cannot have a basis of kind {choice.kind!r}. Take "craig-bampton", whose constraint modes know the chord.'
        )
    if choice.kind == "full":
        if n > LARGEST_FULL:
            raise InputError(
                f'a full basis of {n} coordinates is too large for a mechanism. Take kind = "craig-bampton" with some modes in [basis].'
            )
        return SolidShapes(np.eye(n), "differentiated: identity on the free coordinates, the same at every design")
    rows = {name: (each.rows @ free.map) for name, each in ties.items()}
    moving = {name: row for name, row in rows.items() if abs(row).max() > CLAMPED_ROWS}
    if choice.kind != "eigenmodes":
        turn = None if choice.chord is None else chord_turn(Chord(*choice.chord), list(moving), ties)
        return _with_interface(choice, mass, stiffness, places, free, moving, turn)
    if choice.boundary == "clamped":
        system: ShiftedSystem = held_system(stiffness, csr_array((0, n)), places)
    else:
        system = free_system(stiffness, mass, motions, places)
    kept, beyond = _modes(choice, mass, moving, system)
    return SolidShapes(kept.columns, _words(choice, {}, kept), stiffness, system, kept, beyond)


def _with_interface(
    choice: BasisChoice,
    mass: csr_array,
    stiffness: csr_array,
    places: np.ndarray,
    free: Freedom,
    rows: Mapping[str, csr_array],
    turn: np.ndarray | None,
) -> SolidShapes:
    """Constraint modes of the points in their order, or of what a chord leaves of their motions, then fixed-interface modes."""
    if not rows:
        raise InputError(f"a {choice.kind} basis needs an interface point away from the clamp.")
    m, inside = free.motions, free.n_free
    n_held = m * len(free.rigid)
    averaged = tuple(name for name in rows if name not in free.rigid)
    border = sparse.vstack([csr_array((0, stiffness.shape[0])), *(rows[name] for name in averaged)], format="csr")
    inner = _first_of(stiffness, inside)
    if free.floats:
        inner = supported(inner, [rows[name][:, :inside] for name in averaged])
    system = held_system(inner, border[:, :inside], places[:inside])
    unit = np.eye(n_held)
    carried = system.solve(-(stiffness[:inside, inside:] @ unit), -(border[:, inside:] @ unit))
    lifted = system.solve(np.zeros((inside, border.shape[0])), np.eye(border.shape[0]))
    shapes = {name: np.vstack([carried, unit])[:, m * k : m * k + m] for k, name in enumerate(free.rigid)}
    for k, name in enumerate(averaged):
        shapes[name] = np.vstack([lifted, np.zeros((n_held, border.shape[0]))])[:, m * k : m * k + m]
    static = np.column_stack([shapes[name] for name in rows])
    all_points, static = static, static if turn is None else static @ turn
    if choice.kind == "static":
        words = _words(choice, rows, None)
        beyond = lowest_modes(system, _first_of(mass, inside), lambda found: found.count > 0, 1)
        return SolidShapes(static, words, stiffness, system, None, beyond, n_held, averaged, tuple(rows), all_points, turn)
    kept, beyond = _modes(choice, _first_of(mass, inside), rows, system)
    inside_only = np.vstack([kept.columns, np.zeros((n_held, kept.count))])
    columns = np.column_stack([static, inside_only])
    words = _words(choice, rows, kept)
    return SolidShapes(columns, words, stiffness, system, kept, beyond, n_held, averaged, tuple(rows), all_points, turn)


def _first_of(matrix: csr_array, n: int) -> csr_array:
    """Block of a matrix for the first n coordinates; the matrix itself if these are all."""
    return matrix if n == matrix.shape[0] else matrix[:n, :n].tocsr()


def _modes(
    choice: BasisChoice, mass: csr_array, rows: Mapping[str, csr_array], system: ShiftedSystem
) -> tuple[NormalModes, NormalModes]:
    """Modes to keep, and those beyond them that were found; at least one, to detect a cut cluster."""

    def by_static_error(found: NormalModes) -> int | None:
        return count_by_static_error(found, rows, system, choice.static_error or 0.0)

    def enough(found: NormalModes) -> bool:
        if choice.count is not None:
            return found.count > choice.count
        if choice.frequency is not None:
            return bool(found.frequencies[-1] > choice.frequency)
        return (by_static_error(found) or found.count) < found.count

    every = lowest_modes(system, mass, enough, (choice.count or 0) + EXTRA_MODES)
    count = choice.count or 0
    if choice.frequency is not None:
        count = count_by_frequency(every, choice.frequency, least=1 if choice.kind == "eigenmodes" else 0)
    if choice.static_error is not None:
        count = by_static_error(every) or every.count
    kept = every.lowest(count)
    if choice.derivative == "differentiated":
        refuse_cut_cluster(kept)
    return kept, every.beyond(count)


def _words(choice: BasisChoice, points: Mapping[str, csr_array], modes: NormalModes | None) -> str:
    sizes = [row.shape[0] for row in points.values()]
    n_static = sum(sizes) - (sizes[0] if choice.chord else 0)
    found = [f"{n_static} constraint modes of the interface points {', '.join(points)}"] if points else []
    if modes and modes.count:
        fixed = "fixed-interface" if points else choice.boundary
        found.append(f"{modes.count} {fixed} eigenmodes up to {modes.frequencies[-1]:.6g} Hz")
    return f"{choice.derivative}: {choice.kind}, {' and '.join(found)}"
