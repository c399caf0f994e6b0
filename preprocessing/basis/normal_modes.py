"""Normal modes of a body under linear constraints, or of a free body without its rigid motions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from preprocessing.basis.bordered_system import SingularBorderedSystemError, bordered_system
from preprocessing.basis.constrained_pencil import ConstrainedPencil
from preprocessing.basis.rigid_modes import rigid_modes
from toolkit.foundation.errors import InputError
from toolkit.foundation.mode_shapes import clusters, told_apart


@dataclass(frozen=True, eq=False)
class NormalModes:
    """Lowest modes of K phi = lambda M phi - R^T eta, R phi = 0, with Phi^T M Phi = I, without rigid motions.

    Of modes with equal eigenvalues `shapes` are those that the solver found, whose derivatives are known; `columns` are the same
    ones turned and signed as `toolkit.foundation.mode_shapes` says, which no round-off chooses.
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
