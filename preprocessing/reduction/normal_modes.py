"""Normal modes of a body under linear constraints, how many are kept, and their derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from preprocessing.reduction.constrained_pencil import (
    ConstrainedPencil,
    SingularBorderedSystemError,
    bordered_system,
    rigid_modes,
)
from toolkit.foundation.errors import InputError
from toolkit.foundation.near_ties import EQUAL_EIGENVALUES, clusters, told_apart


@dataclass(frozen=True, eq=False)
class NormalModes:
    """Lowest modes of K phi = lambda M phi - R^T eta, R phi = 0, with Phi^T M Phi = I, without rigid motions.

    Of modes with equal eigenvalues `shapes` are those that the solver found, whose derivatives are known; `columns` are the same
    ones turned and signed as `toolkit.foundation.near_ties` says, which no round-off chooses.
    """

    pencil: ConstrainedPencil
    eigenvalues: np.ndarray  # (m,), in 1/s^2
    shapes: np.ndarray  # (n, m)
    multipliers: np.ndarray  # (n_r, m)
    discarded: np.ndarray  # eigenvalues of all higher modes
    columns: np.ndarray  # (n, m)

    @property
    def count(self) -> int:
        """Number of the modes that are kept."""
        return len(self.eigenvalues)

    @property
    def spectrum(self) -> np.ndarray:
        """All eigenvalues, kept and left out, in order."""
        return np.concatenate([self.eigenvalues, self.discarded])

    @property
    def frequencies(self) -> np.ndarray:
        """Eigenfrequencies of the modes that are kept, in Hz, (m,)."""
        return frequencies(self.eigenvalues)

    def lowest(self, count: int) -> NormalModes:
        """Lowest `count` of these modes.

        Raises
        ------
        InputError
            There are not so many.
        """
        if not 0 <= count <= self.count:
            possible = f"Choose from 0 to {self.count}." if self.count else "Choose 0: what is held leaves no motion."
            raise InputError(f"{count} modes cannot be taken: the mesh has {self.count}. {possible}")
        return replace(
            self,
            eigenvalues=self.eigenvalues[:count],
            shapes=self.shapes[:, :count],
            multipliers=self.multipliers[:, :count],
            discarded=self.spectrum[count:],
            columns=self.columns[:, :count],
        )

    def beyond(self, count: int) -> NormalModes:
        """Modes above the lowest `count`."""
        rest = {name: getattr(self, name)[:, count:] for name in ("shapes", "multipliers", "columns")}
        return replace(self, eigenvalues=self.eigenvalues[count:], **rest)

    def turned(self, rates: np.ndarray) -> np.ndarray:
        """Derivatives of the columns from those of the shapes, both (n, m, ...); the cluster of the last mode is kept whole."""
        return np.einsum("ij...,jk->ik...", rates, self.shapes.T @ (self.pencil.mass @ self.columns))


def slowest_left_out(beyond: np.ndarray, points: bool) -> dict[str, float]:
    """Lowest frequency left out, as in `ReducedModel.left_out`, from eigenvalues; interface points are held or not."""
    return {"interface" if points else "frame": float(frequencies(np.min(beyond, initial=np.inf)))}


def frequencies(eigenvalues: np.ndarray) -> np.ndarray:
    """Eigenfrequencies sqrt(lambda) / 2 pi in Hz."""
    return np.sqrt(eigenvalues) / (2 * np.pi)


def cluster(spectrum: np.ndarray, mode: int) -> tuple[int, int]:
    """First mode, and first mode behind, of the cluster of equal eigenvalues that `mode` (counted from 0) belongs to."""
    return next((first, behind) for first, behind in clusters(spectrum) if first <= mode < behind)


def normal_modes(pencil: ConstrainedPencil, count: int | None = None) -> NormalModes:
    """Lowest `count` normal modes, or all.

    Low modes are eigenvectors of the flexibility (relative accuracy round-off times lambda / lambda_1), high modes of the stiffness
    (round-off times lambda_n / lambda), so that all are accurate on fine meshes whose lambda_n / lambda_1 is beyond 1e10. One step
    of inverse iteration takes the round-off out of the low modes that lies along the stiffest ones: dK, which may turn the stiff
    directions, would multiply it by lambda_n / lambda_1.

    Raises
    ------
    InputError
        The mesh has fewer modes, the constraints are not independent, or the mass matrix is not positive definite.
    """
    rigid = rigid_modes(pencil)
    border = np.vstack([pencil.rows, rigid.T @ pencil.mass])
    try:
        system = bordered_system(pencil.stiffness, border)
        factor = np.linalg.cholesky(pencil.mass)
    except (SingularBorderedSystemError, np.linalg.LinAlgError) as error:
        raise InputError(
            f"normal modes need independent constraint rows and a positive definite mass matrix, but {error}. Name every interface "
            "point once, and give every element a mass."
        ) from error
    allowed = _allowed(solve_triangular(factor, border.T, lower=True))
    flexibility = allowed.T @ factor.T @ system.solve(factor @ allowed)[0]
    _, turned = np.linalg.eigh(-(flexibility + flexibility.T) / 2)
    elastic = solve_triangular(factor, allowed @ turned, lower=True, trans="T")
    eigenvalues, shapes, split = _stiff_modes_again(pencil.stiffness, elastic)
    low = system.solve(pencil.mass @ shapes[:, :split] * eigenvalues[:split])[0]
    shapes = _orthonormal(np.column_stack([low, shapes[:, split:]]), pencil.mass)
    multipliers = system.solve(pencil.mass @ shapes * eigenvalues)[1][: len(pencil.rows)]
    columns = told_apart(eigenvalues, shapes, np.sqrt(np.diag(pencil.mass)))
    modes = NormalModes(pencil, eigenvalues, shapes, multipliers, np.zeros(0), columns)
    return modes if count is None else modes.lowest(count)


def _allowed(held: np.ndarray) -> np.ndarray:
    """Orthonormal columns (n, n - k) of all that is perpendicular to the columns held (n, k)."""
    return np.linalg.qr(held, mode="complete")[0][:, held.shape[1] :]


def _orthonormal(shapes: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Every shape without its part along those before it, at unit mass."""
    return solve_triangular(np.linalg.cholesky(shapes.T @ mass @ shapes), shapes.T, lower=True).T


def _stiff_modes_again(stiffness: np.ndarray, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Eigenvalues, shapes, and where the upper half begins, which comes from the stiffness on its own span; at a wide gap."""
    rough = np.einsum("ij,ij->j", shapes, stiffness @ shapes)
    middle = np.sqrt(rough[:1] * rough[-1:])
    ratio = np.divide(rough[1:], rough[:-1], where=np.abs(np.log10(rough[1:] / middle)) < 1, out=np.ones(max(len(rough) - 1, 0)))
    split = int(np.argmax(ratio)) + 1 if len(ratio) else len(rough)
    high = shapes[:, split:]
    upper, turn = np.linalg.eigh(high.T @ stiffness @ high)
    return np.concatenate([rough[:split], upper]), np.column_stack([shapes[:, :split], high @ turn]), split


def subspace_rates(modes: NormalModes, d_pencils: Sequence[ConstrainedPencil]) -> np.ndarray:
    """Derivatives dPhi (n, m, n_x) of the kept modes by the design variables whose dK, dM and dR are given.

    For every mode j one matrix is factored, for all variables, and dropped again (eta: multipliers of the mode):

        [K - lambda_j M, R^T, M Phi] [ dphi_j]   [-(dK - lambda_j dM) phi_j - dR^T eta_j]
        [R,              0,   0    ] [ deta_j] = [-dR phi_j                             ]
        [Phi^T M,        0,   0    ] [-dS_j  ]   [-1/2 Phi^T dM phi_j                   ]

    Nelson's method (AIAA J. 14 (1976) 1201) bordered by all kept modes instead of one: equal eigenvalues among them leave the
    matrix regular. The motion of Phi inside its own span, which no response of the reduced body feels, is fixed by
    Phi^T M dPhi = -1/2 Phi^T dM Phi.

    Raises
    ------
    InputError
        The highest kept and the lowest discarded eigenvalue are equal, so that the span has no derivative.
    """
    refuse_cut_cluster(modes)
    if not modes.count or not d_pencils:
        return np.zeros((*modes.shapes.shape, len(d_pencils)))
    kept = range(modes.count)
    loads = mode_loads(modes, d_pencils)
    return np.stack([mode_rates(modes, j, kept, loads) for j in kept], axis=1)


@dataclass(frozen=True, eq=False)
class ModeLoads:
    """Products of the matrices' derivatives with every mode; the last axis is the design variable."""

    inertia: np.ndarray  # dM phi_j, (n, m, n_x)
    force: np.ndarray  # (dK - lambda_j dM) phi_j + dR^T eta_j, (n, m, n_x)
    gap: np.ndarray  # dR phi_j, (n_r, m, n_x)


def mode_loads(modes: NormalModes, d_pencils: Sequence[ConstrainedPencil]) -> ModeLoads:
    """Products of dK, dM and dR with all modes."""
    inertia = np.stack([d.mass @ modes.shapes for d in d_pencils], axis=-1)
    force = np.stack([d.stiffness @ modes.shapes + d.rows.T @ modes.multipliers for d in d_pencils], axis=-1)
    gap = np.stack([d.rows @ modes.shapes for d in d_pencils], axis=-1)
    return ModeLoads(inertia, force - modes.eigenvalues[:, None] * inertia, gap)


def mode_rates(modes: NormalModes, mode: int, border: Sequence[int], loads: ModeLoads) -> np.ndarray:
    """Derivatives dphi (n, n_x) of one mode from the system of `subspace_rates`, bordered by the modes `border`."""
    pencil, basis = modes.pencil, modes.shapes[:, list(border)]
    shifted = pencil.stiffness - modes.eigenvalues[mode] * pencil.mass
    system = bordered_system(shifted, np.vstack([pencil.rows, basis.T @ pencil.mass]))
    below = np.vstack([-loads.gap[:, mode], -basis.T @ loads.inertia[:, mode] / 2])
    return system.solve(-loads.force[:, mode], below)[0]


def refuse_cut_cluster(modes: NormalModes) -> None:
    """Refuse kept modes whose last one has the eigenvalue of the first one left out.

    Raises
    ------
    InputError
        It names the modes, their frequencies, and the next numbers of modes that have a derivative.
    """
    m, spectrum = modes.count, modes.spectrum
    if m in (0, len(spectrum)):
        return
    first, behind = cluster(spectrum, m - 1)
    if behind > m:
        below, above = frequencies(spectrum[m - 1 : m + 1])
        fewer = f"{first} or {behind}" if first else f"{behind}"
        raise InputError(
            f"mode {m} ({below:.6g} Hz) is kept and mode {m + 1} ({above:.6g} Hz) is left out, but their eigenvalues are equal (to "
            f"{spectrum[m] / spectrum[m - 1] - 1:.0e}), so that the basis has no derivative. Keep {fewer} modes, or take the "
            'derivative "frozen".'
        )


def eigenvalue_rates(modes: NormalModes, d_pencil: ConstrainedPencil) -> np.ndarray:
    """Derivatives of the eigenvalues by one design variable, (m,).

    A single eigenvalue has dlambda = phi^T (dK - lambda dM) phi + 2 eta^T dR phi. A repeated one splits when the design changes: its
    branches have the eigenvalues of the same expression with all modes of the cluster, in increasing order.

    Raises
    ------
    InputError
        The highest kept and the lowest discarded eigenvalue are equal.
    """
    return _split(modes, d_pencil)[0]


def adapted_modes(modes: NormalModes, d_pencil: ConstrainedPencil) -> NormalModes:
    """Modes turned inside every repeated eigenvalue so that each continues smoothly when the design variable changes.

    They stand in the order of `eigenvalue_rates`; branches of equal derivative stay undetermined.

    Raises
    ------
    InputError
        The highest kept and the lowest discarded eigenvalue are equal.
    """
    turn = _split(modes, d_pencil)[1]
    return replace(modes, shapes=modes.shapes @ turn, multipliers=modes.multipliers @ turn)


def eigenvector_rates(modes: NormalModes, d_pencil: ConstrainedPencil) -> np.ndarray:
    """Derivatives (n, m) of mass-normalised modes with single eigenvalues by one design variable, Nelson's method.

    Raises
    ------
    InputError
        An eigenvalue is repeated: the derivative of its vectors depends on second derivatives of the matrices.
    """
    for first, behind in _clusters(modes):
        if behind - first > 1:
            numbers = ", ".join(str(mode + 1) for mode in range(first, behind))
            raise InputError(
                f"the modes {numbers} have one eigenvalue ({frequencies(modes.spectrum[first]):.6g} Hz), and single vectors of a "
                "repeated eigenvalue have no derivative from first derivatives of the matrices. Use eigenvalue_rates, "
                "adapted_modes, or the derivative of their span, subspace_rates."
            )
    loads = mode_loads(modes, [d_pencil])
    rates = [mode_rates(modes, j, [j], loads)[:, 0] for j in range(modes.count)]
    return np.column_stack(rates) if rates else np.zeros_like(modes.shapes)


def _clusters(modes: NormalModes) -> list[tuple[int, int]]:
    """Numbers (first, first behind) of every cluster that holds a kept mode."""
    return sorted({cluster(modes.spectrum, mode) for mode in range(modes.count)})


def _split(modes: NormalModes, d_pencil: ConstrainedPencil) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the eigenvalues (m,) and the turn (m, m) of the modes that belongs to them."""
    refuse_cut_cluster(modes)
    rates, turn = np.zeros(modes.count), np.zeros((modes.count, modes.count))
    for first, behind in _clusters(modes):
        members = slice(first, behind)
        rates[members], turn[members, members] = np.linalg.eigh(_coupling(modes, members, d_pencil))
    return rates, turn


def _coupling(modes: NormalModes, members: slice, d_pencil: ConstrainedPencil) -> np.ndarray:
    """Coupling Phi^T (dK - lambda dM) Phi + H^T dR Phi + Phi^T dR^T H of one cluster with multipliers H."""
    phi, eta = modes.shapes[:, members], modes.multipliers[:, members]
    eigenvalue = modes.eigenvalues[members].mean()
    work = eta.T @ (d_pencil.rows @ phi)
    return phi.T @ (d_pencil.stiffness @ phi) - eigenvalue * (phi.T @ (d_pencil.mass @ phi)) + work + work.T


def count_by_frequency(modes: NormalModes, highest: float, least: int = 1) -> int:
    """Number of modes up to the frequency `highest` in Hz; a cluster of equal eigenvalues is taken whole, and what equals `highest` counts.

    Parameters
    ----------
    modes : all modes of the mesh
    least : smallest number that makes sense: 1 for a basis of modes alone, 0 beside constraint modes

    Raises
    ------
    InputError
        No mode is so low, or the mesh has no mode so high.
    """
    found = modes.frequencies
    if not len(found):
        raise InputError("no mode can be chosen by frequency: the boundary leaves no motion. Name fewer interface points.")
    if not highest <= found[-1] * (1 + EQUAL_EIGENVALUES):
        raise InputError(f"modes up to {highest:g} Hz cannot be told: the mesh ends at {found[-1]:.6g} Hz. Use more elements.")
    count = int(np.count_nonzero(found <= highest * (1 + EQUAL_EIGENVALUES)))
    if count < least:
        raise InputError(f"no mode lies below {highest:g} Hz: the lowest has {found[0]:.6g} Hz. Choose a higher frequency.")
    return cluster(modes.spectrum, count - 1)[1] if count else 0


def count_by_static_error(modes: NormalModes, interface_rows: np.ndarray, largest: float) -> int:
    """Smallest number of modes whose `static_errors` is at most `largest`; a cluster of equal eigenvalues is taken whole.

    Parameters
    ----------
    modes : all modes of the mesh
    interface_rows : (k, n)

    Raises
    ------
    InputError
        The request is invalid, or no interface point can move.
    """
    check_static_error(largest)
    errors = static_errors(modes, interface_rows)
    return cluster(modes.spectrum, int(np.argmax(errors <= largest)) - 1)[1]


def check_static_error(largest: float) -> None:
    """Refuse a wanted static error that no number of modes can have.

    Raises
    ------
    InputError
        It is not between 0 and 1.
    """
    if not 0 < largest < 1:
        raise InputError(f"a static error of {largest:g} is invalid: without modes it is 1, with all it is 0; write 0.01, say.")


def static_errors(modes: NormalModes, interface_rows: np.ndarray) -> np.ndarray:
    """Relative static error at the interface points when only the lowest k modes are kept, for k = 0, 1, ..., all: (1 + m,).

        || C - C_k || / || C ||,     C = R K^-1 R^T = sum_j (R phi_j) (R phi_j)^T / lambda_j,  C_k: the first k terms

    with the largest singular value as the norm. Every row of R is first divided by the square root of its own compliance, so that
    displacements and rotations count alike. Of a free body, C belongs to loads whose inertia forces keep them in balance.

    Raises
    ------
    InputError
        No interface point can move.
    """
    moves = interface_rows @ modes.shapes / np.sqrt(modes.eigenvalues)  # (k, m)
    own = np.sqrt((moves**2).sum(axis=1))
    able = own > 1e-9 * _largest_possible(modes, interface_rows)  # rows on the clamped node move by round-off
    if not able.any():
        raise InputError("a static error needs an interface point that can move: name one away from the clamped node.")
    scaled = moves[able] / own[able, None]
    whole = np.linalg.norm(scaled, 2)  # of moves: the norms of the compliances are the squares
    return np.array([np.linalg.norm(scaled[:, k:], 2) for k in range(modes.count)] + [0.0]) ** 2 / whole**2


def _largest_possible(modes: NormalModes, interface_rows: np.ndarray) -> np.ndarray:
    """Size of sqrt(R K^-1 R^T) if all of a row followed the softest mode, (k,)."""
    return np.linalg.norm(interface_rows / np.sqrt(np.diag(modes.pencil.mass)), axis=1) / np.sqrt(modes.eigenvalues[:1])
