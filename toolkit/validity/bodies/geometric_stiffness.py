"""Geometric stiffness of the beam elements behind a body, the forces at its points, and the compliance of a whole scene.

The largest ratio of two forms among the motions that joints allow, where there are many coordinates: by Lanczos' iteration.

    A x = mu B x + phi_q^T nu,    phi_q x = 0

with B positive against these motions. Dense eigenvalues of n coordinates cost n^3, these the few products with sparse factors of B.

Geometric stiffness of the beam elements behind a body: what their forces do to a lateral motion in the body's frame.

An element that turns, or bows, changes its deformations by d_2 = u_e^T Q u_e / 2 (`known_chain`). Forces s of the linear
element do the work s . d_2 on that and so add sum_k s_k Q_k to the stiffness. Linear FFRF lacks it. What the frame's own rotation does to
the forces at joints is in the equations of motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy

from toolkit.description.design import BodyPoint
from toolkit.responses.balance import law_of_load
from toolkit.responses.least_squares_forces import wrenches_of_joints
from toolkit.responses.marker_formula import MarkerMotion
from toolkit.scene.resolution import ResolvedScene
from toolkit.solvers.direct_solve import SPARSE_FROM_UNKNOWNS
from toolkit.solvers.static.equilibrium import LEVELS
from toolkit.solvers.static.static_matrix import (
    StaticArray,
    as_dense,
    balance,
    balanced,
    scaled_by,
    sparse_factors,
    static_array,
    whole_array,
)
from toolkit.system.numbering import grips_of
from toolkit.system.quantities import named_loads
from toolkit.system.solution import Solution, design_point, flexible_body
from toolkit.system.system import System
from toolkit.validity.bodies.chain import Chain
from toolkit.validity.bodies.known_chain import chain

RATIO_ACCURACY = 1e-8
"""Relative accuracy of a ratio: far below the digits of a verdict."""
MOST_RESTARTS = 50
"""Largest number of restarts of the iteration with twenty motions: a ratio that is apart from others is found in a few."""
Flexibility = Callable[[np.ndarray], np.ndarray]
"""Function from forces f (n,) to the motion x with B x + phi_q^T nu = f, phi_q x = 0."""


def flexibility(system: System, matrix: StaticArray) -> Flexibility | None:
    """Flexibility of a symmetric static matrix.

    None where the matrix is dense, not known to be stable, or of more than bodies and joints.
    """
    n_q, scale = system.n_q, balance(system, matrix)
    factors = sparse_factors(system, balanced(system, matrix, scale)) if n_q == system.n_b else None
    if factors is None:
        return None

    def motion(forces: np.ndarray) -> np.ndarray:
        found: np.ndarray = scale[:n_q] * factors.solve(np.append(scale[:n_q] * forces.ravel(), np.zeros(system.n - n_q)))[:n_q]
        return found

    return motion


def largest_ratio(matrix: scipy.sparse.sparray, metric: scipy.sparse.sparray, flexible: Flexibility) -> float | None:
    """Largest ratio mu of symmetric forms A and B (n, n); None if the iteration finds none, as where none is positive.

    Most mu are near to zero, and the relative accuracy of such a number is never reached.
    """
    n = metric.shape[0]
    start = flexible(np.random.default_rng(0).normal(size=n))
    solved = scipy.sparse.linalg.LinearOperator((n, n), matvec=flexible, dtype=float)
    try:
        found = scipy.sparse.linalg.eigsh(
            matrix,
            1,
            metric,
            which="LA",
            v0=start,
            tol=RATIO_ACCURACY,
            maxiter=MOST_RESTARTS,
            Minv=solved,
            return_eigenvectors=False,
        )
    except scipy.sparse.linalg.ArpackError:
        return None
    return float(found[0])


def forces_at_points(solution: Solution, body: str, instants: np.ndarray) -> dict[str, np.ndarray]:
    """Interface point -> force (n_t, d) on the body at some instants, in the axes of its reduced model."""
    d = solution.system.scene.dimension
    return {name: wrench[:, :d] for name, wrench in wrenches_at_points(solution, body, instants).items()}


def wrenches_at_points(solution: Solution, body: str, instants: np.ndarray) -> dict[str, np.ndarray]:
    """Interface point -> force and moment about it on the body at some instants, in the axes of its reduced model; (n_t, 3 or 6)."""
    scene, where = solution.system.scene, solution.coordinates(body)
    written: Any = flexible_body(scene, body)
    axes = written.poses(np.real(solution.q[instants][:, where]))[1]
    found: dict[str, np.ndarray] = {}
    for point, wrench in [*_of_loads(solution, body, instants), *_of_joints(solution, body, instants)]:
        place = scene.points[point]
        if isinstance(place, BodyPoint):
            found[place.interface] = found.get(place.interface, 0.0) + _turned_back(axes, wrench)
    return found


def _turned_back(axes: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    """Force and moment (n_t, 3 or 6) in axes (n_t, d, d); the moment of the plane is what it is."""
    vectors = [wrench[:, :2]] if axes.shape[1] == 2 else [wrench[:, :3], wrench[:, 3:]]
    turned = [np.einsum("tij,ti->tj", axes, each) for each in vectors]
    return np.concatenate([*turned, wrench[:, 2:]] if len(turned) == 1 else turned, axis=1)


def _of_loads(solution: Solution, body: str, instants: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Point and force with moment (n_t, 3 or 6) in space of every load that grips the body."""
    system = solution.system
    curves = system.curves(solution.times)[0]
    for k, (name, load) in enumerate(named_loads(system.scene).items()):
        points = [(side, point) for side, (gripped, point) in enumerate(load.grips) if gripped == body]
        if not points:
            continue
        motion, curve, state = MarkerMotion.of(system, grips_of(f"loads.{name}", load)), *_numbers(solution, k)
        forces = []
        for n in instants:
            a, b = motion.at(solution, n)
            own = solution.q[n, state] if state >= 0 else 0.0
            force = np.real(law_of_load(system, load, k, (a, b), own, curves[n, curve, 0] if curve >= 0 else 1.0)[0])
            forces.append([_wrench(a.y, force[: len(a.y)]), _wrench(b.y, force[len(a.y) : 2 * len(a.y)])])
        for side, point in points:
            yield point, np.array(forces)[:, side]


def _wrench(pose: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Force and moment of what does work along a pose, 3 numbers in the plane, a position and three axes in space."""
    if len(pose) == 3:
        return np.real(force)
    moment = np.cross(pose[3:].reshape(3, 3), force[3:].reshape(3, 3)).sum(axis=0)
    return np.real(np.concatenate([force[:3], moment]))


def _numbers(solution: Solution, load: int) -> tuple[int, int]:
    """Where the curve and the own state of a load are; negative without one."""
    loads = solution.system.plan.loads
    return loads.curve[load], loads.state[load]


def _of_joints(solution: Solution, body: str, instants: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Point and force with moment (n_t, 3 or 6) in space of every joint that holds the body."""
    holding = [
        (j, side, point)
        for j, joint in enumerate(solution.system.scene.joints.values())
        for side, (gripped, point) in enumerate(joint.grips)
        if gripped == body
    ]
    if holding:
        joints = wrenches_of_joints(solution)
        found = np.array([joints.at(int(n)) for n in instants])
        for j, side, point in holding:
            yield point, found[:, j, side]


@dataclass(frozen=True, eq=False)
class Stiffening:
    """How the elements of one body stiffen it under their forces, and soften it; matrices in its elastic coordinates."""

    behind: Chain
    stiffness: np.ndarray  # (n_f, n_f)

    def matrix(self, elastic: np.ndarray) -> StaticArray:
        """G at elastic coordinates (n_f,), (n_f, n_f); sparse where there are many."""
        forms, stiffening = self.behind.forms, self.behind.stiffening
        forces = forms.forces(self.behind.displacements(elastic[None]))[0, :, : stiffening.shape[1]]
        return self._elastic(forms.assembled(np.einsum("ek,ekpq->epq", forces, stiffening)))

    def of_axial(self, axial: np.ndarray) -> StaticArray:
        """G of axial forces (n_e,) alone, (n_f, n_f)."""
        return self._elastic(self.behind.forms.assembled(axial[:, None, None] * self.behind.stiffening[:, 0]))

    def yielding(self, forces: np.ndarray) -> np.ndarray:
        """K^-1 f of forces (n_f,), the body alone in its frame."""
        found: np.ndarray = self._scale * self._flexible(self._scale * forces)
        return found

    def softening(self, elastic: np.ndarray) -> float:
        """The largest part of its elastic stiffness that the forces take from any motion of the body in its frame."""
        G = scaled_by(self.matrix(elastic), self._scale)
        found = None if isinstance(G, np.ndarray) else largest_ratio(-G, scipy.sparse.csr_array(self._scaled), self._flexible)
        if found is None:
            half = np.linalg.solve(self._root, -as_dense(G))
            found = float(np.linalg.eigvalsh(np.linalg.solve(self._root, half.T))[-1])
        return max(found, 0.0)

    def deflections(self, elastic: np.ndarray, motions: np.ndarray) -> np.ndarray:
        """K^-1 G of motions (n_f, k): what the forces at elastic coordinates (n_f,) would bend the body by, to first order."""
        G = scaled_by(self.matrix(elastic), self._scale)
        bent: np.ndarray = self._scale[:, None] * self._flexible(np.asarray(G @ (motions / self._scale[:, None])))
        return bent

    @cached_property
    def forces(self) -> np.ndarray:
        """Axial forces of the elements, (n_e, n_f), positive in tension."""
        return self.behind.axial_forces(self.behind.shapes.T).T

    @cached_property
    def compliances(self) -> np.ndarray:
        """int w'^2 dx of every element under unit forces on all motions, (n_e,): which elements compression makes soft."""
        scaled = self._scale[:, None] * self.behind.shapes.T
        dofs, forms = self.behind.forms.dofs, self.behind.stiffening[:, 0]
        yielding = self._flexible(scaled)
        of_elements = np.einsum("fep,feq->epq", scaled[:, dofs], yielding[:, dofs])
        found: np.ndarray = np.einsum("epq,epq->e", forms, of_elements)
        return found

    def _elastic(self, nodal: scipy.sparse.csc_array) -> StaticArray:
        shapes = self._shapes
        found: StaticArray = shapes.T @ nodal @ shapes
        return found

    @cached_property
    def _shapes(self) -> StaticArray:
        return scipy.sparse.csr_array(self.behind.shapes) if len(self.stiffness) >= SPARSE_FROM_UNKNOWNS else self.behind.shapes

    @cached_property
    def _flexible(self) -> Flexibility:
        """The inverse of the scaled stiffness."""
        if len(self.stiffness) < SPARSE_FROM_UNKNOWNS:
            return lambda forces: np.linalg.solve(self._scaled, forces)
        factors = scipy.sparse.linalg.splu(scipy.sparse.csc_array(self._scaled))
        return lambda forces: factors.solve(forces)

    @cached_property
    def _scale(self) -> np.ndarray:
        return 1 / np.sqrt(np.diag(self.stiffness))

    @cached_property
    def _root(self) -> np.ndarray:
        """L of the scaled stiffness L L^T."""
        found: np.ndarray = np.linalg.cholesky(self._scaled)
        return found

    @cached_property
    def _scaled(self) -> np.ndarray:
        return self._scale[:, None] * self.stiffness * self._scale


def stiffening(scene: ResolvedScene, body: str) -> Stiffening | None:
    """The geometric stiffness of a flexible body; None if its reduced model does not hold its finite elements."""
    behind, design = chain(scene, body), design_point(scene, body)
    if behind is not None and Stiffening not in design.kept:
        design.kept[Stiffening] = Stiffening(behind, np.real(design.value("stiffness")))
    found: Stiffening | None = design.kept.get(Stiffening)
    return found


HOLDING_PERIOD = 30.0
"""Period, relative to the duration, of the vibration whose inertia holds free motions: a thousandth of the stiffness at one."""
Solver = Callable[[np.ndarray], np.ndarray]


class Yielding(NamedTuple):
    """Compliance of a scene at one state: maps forces (n_q,) to motions (n_q,) that joints allow."""

    solved: Solver  # of all unknowns, balanced
    scale: np.ndarray  # (n,) what balances them
    n_q: int

    def __call__(self, forces: np.ndarray) -> np.ndarray:
        return self._solution(forces)[: self.n_q]

    def multipliers(self, forces: np.ndarray) -> np.ndarray:
        """Multipliers by which joints hold these forces."""
        return self._solution(forces)[self.n_q :]

    def _solution(self, forces: np.ndarray) -> np.ndarray:
        whole = np.append(forces, np.zeros(len(self.scale) - self.n_q))
        found: np.ndarray = self.scale * self.solved(self.scale * whole)
        return found


def yielding(solution: Solution, n: int) -> Yielding | None:
    """Compliance of the scene at state `n`; None where it is not unique.

    What nothing holds in a motion has its inertia, of a vibration that takes much longer than the motion.
    """
    system, n_q = solution.system, solution.system.n_q
    pad = np.zeros(system.n - n_q)
    q, v = (np.append(np.real(state[n]), pad) for state in (solution.q, solution.v))
    acc = np.real(np.append(solution.a[n], solution.multipliers[n]))
    terms = system.evaluate(system.inputs(float(solution.times[n]), LEVELS), q, v, acc)
    matrix = static_array(system, terms)
    duration = float(solution.times[-1] - solution.times[0])
    if solution.steps and duration > 0:
        rate = (2 * np.pi / (HOLDING_PERIOD * duration)) ** 2
        matrix = matrix + rate * _of_coordinates(whole_array(system, np.real(terms.I_acc)), n_q)
    scale = balance(system, matrix)
    solved = _solver(balanced(system, matrix, scale))
    return None if solved is None else Yielding(solved, scale, n_q)


def _of_coordinates(mass: StaticArray, n_q: int) -> StaticArray:
    """A mass matrix with zero rows and columns at the multipliers."""
    kept = np.arange(mass.shape[0]) < n_q
    if isinstance(mass, np.ndarray):
        found: np.ndarray = mass * kept * kept[:, None]
        return found
    only = scipy.sparse.diags_array(kept.astype(float))
    return scipy.sparse.csr_array(only @ mass @ only)


def _solver(matrix: StaticArray) -> Solver | None:
    """Solver of A x = f; None where A is singular."""
    if not isinstance(matrix, np.ndarray):
        try:
            return scipy.sparse.linalg.splu(scipy.sparse.csc_array(matrix)).solve  # type: ignore[no-any-return]
        except RuntimeError:  # exactly singular
            return None
    factors, pivots, info = scipy.linalg.lapack.dgetrf(matrix)
    if info:
        return None
    return lambda forces: scipy.linalg.lapack.dgetrs(factors, pivots, forces)[0]  # type: ignore[no-any-return]
