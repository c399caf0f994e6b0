"""Planar beams of corotational elements under the forces of linear ones: the truth that the small-deformation meter estimates.

Planar corotational beam elements: the linear element of a chain (`planar_chain`) in axes that turn with its chord.

An element of length L and nodal coordinates u_e = (x, y, rotation) at both ends has the deformed chord of length l and direction e_l,
n_l = e_l turned by +90 degrees, which has turned by alpha. Against the chord it deforms as the linear element does:

    a = l - L,    phi_i = rotation_i - alpha,    N = E A a / L,    m = S phi, S = E I / L [4 2; 2 4] without shear
    r = [-e_l, 0, e_l, 0] = da/du_e,    s = [-n_l, 0, n_l, 0] = l dalpha/du_e,    b_i = dphi_i/du_e = (1 at rotation i) - s / l
    force      f = N r + m_1 b_1 + m_2 b_2
    tangent    E A / L r r^T + sum_ij S_ij b_i b_j^T + N / l s s^T + (m_1 + m_2) / l^2 (r s^T + s r^T)

Rigid motions of any size leave no force. Crisfield, Non-linear Finite Element Analysis of Solids and Structures 1 (1991), chapter 7.

Equilibrium of a frame of corotational elements under given loads, by Newton's method with steps of the load.

The frame of the body is held by rows C u = 0, as in its reduced model; their forces p take up what the loads do not balance:

    f(u) + C^T p = factor F,    C u = 0,    factor from 0 to 1
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy

from toolkit.foundation.errors import InputError
from toolkit.reduced_model.model import StressPoints
from toolkit.reduced_model.parts import BeamSections
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution, design_point, elastic_coordinates, flexible_body
from toolkit.validity.bodies.deformation import Deformation, deformation_of, flexible_bodies, kept_back
from toolkit.validity.bodies.known_chain import PlanarChain, chain, planar_law


class Deformed(NamedTuple):
    """Deformed state of all elements, first axis elements; complex if the displacements are."""

    chord: np.ndarray  # l
    stretch: np.ndarray  # a
    bend: np.ndarray  # phi (n_e, 2)
    r: np.ndarray  # (n_e, 6)
    s: np.ndarray  # (n_e, 6)
    b: np.ndarray  # (n_e, 2, 6)


@dataclass(frozen=True)
class Corotational:
    """A frame of corotational elements; nodal displacements are (n,), three per node."""

    nodes: np.ndarray  # (n_nodes, 2)
    connectivity: np.ndarray  # (n_e, 2)
    made_of: BeamSections

    @cached_property
    def dofs(self) -> np.ndarray:
        """Numbers of the nodal coordinates of every element, (n_e, 6)."""
        return (3 * self.connectivity[:, :, None] + np.arange(3)).reshape(-1, 6)

    @cached_property
    def sides(self) -> np.ndarray:
        """Vectors from the first to the second end of every undeformed element, (n_e, 2)."""
        return self.nodes[self.connectivity[:, 1]] - self.nodes[self.connectivity[:, 0]]

    @cached_property
    def lengths(self) -> np.ndarray:
        """Lengths L of the undeformed elements, (n_e,)."""
        return np.linalg.norm(self.sides, axis=1)

    @cached_property
    def law(self) -> np.ndarray:
        """Axial force and end moments by elongation and rotations against the chord, (n_e, 3, 3)."""
        return planar_law(self.made_of, self.lengths)

    def deformed(self, u: np.ndarray) -> Deformed:
        """Chord lengths, deformations and their derivatives at displacements u; complex u gives complex steps."""
        moved, along = u.reshape(-1, 3)[self.connectivity], self.sides / self.lengths[:, None]
        across = np.column_stack([-along[:, 1], along[:, 0]])
        side = self.sides + moved[:, 1, :2] - moved[:, 0, :2]
        chord = np.sqrt((side * side).sum(axis=1))
        e = side / chord[:, None]
        alpha = _angle((e * along).sum(axis=1), (e * across).sum(axis=1), moved[:, :, 2].mean(axis=1))
        zero = 0 * chord
        r = np.column_stack([-e, zero, e, zero])
        s = np.column_stack([e[:, 1], -e[:, 0], zero, -e[:, 1], e[:, 0], zero])
        b = np.repeat(-s[:, None] / chord[:, None, None], 2, axis=1)
        b[:, 0, 2] += 1
        b[:, 1, 5] += 1
        return Deformed(chord, chord - self.lengths, moved[:, :, 2] - alpha[:, None], r, s, b)

    def end_forces(self, state: Deformed) -> tuple[np.ndarray, np.ndarray]:
        """Axial force N (n_e,) and moments m at both ends (n_e, 2)."""
        return self.law[:, 0, 0] * state.stretch, np.einsum("eij,ej->ei", self.law[:, 1:, 1:], state.bend)

    def force(self, u: np.ndarray) -> np.ndarray:
        """Internal forces on the nodal coordinates, (n,)."""
        state = self.deformed(u)
        force, moments = self.end_forces(state)
        each = force[:, None] * state.r + np.einsum("ei,eik->ek", moments, state.b)
        found = np.zeros(len(u), each.dtype)
        np.add.at(found, self.dofs, each)
        return found

    def tangent(self, u: np.ndarray) -> scipy.sparse.csc_array:
        """Derivative of `force`, sparse (n, n)."""
        state = self.deformed(u)
        (force, moments), r, s, b = self.end_forces(state), state.r, state.s, state.b
        turned = moments.sum(axis=1) / state.chord**2
        blocks = self.law[:, 0, 0][:, None, None] * _outer(r, r) + (force / state.chord)[:, None, None] * _outer(s, s)
        blocks += np.einsum("eik,eij,ejl->ekl", b, self.law[:, 1:, 1:], b)
        blocks += turned[:, None, None] * (_outer(r, s) + _outer(s, r))
        row, column = np.broadcast_arrays(self.dofs[:, :, None], self.dofs[:, None, :])
        return scipy.sparse.coo_array((blocks.ravel(), (row.ravel(), column.ravel())), shape=(len(u), len(u))).tocsc()

    def stress(self, u: np.ndarray, places: StressPoints) -> np.ndarray:
        """Stress at stress points, (n_stress,): stress_per_strain (eps - y kappa) at a fibre y of one of the ends of an element."""
        state, made_of = self.deformed(u), self.made_of
        kappa = self._curvature(state.bend)[places.element, places.end]
        eps = (state.stretch / self.lengths)[places.element]
        stress: np.ndarray = made_of.stress_per_strain[places.element] * (eps - made_of.fibre_distance[:, 0] * kappa)
        return stress

    def linear_stress(self, u: np.ndarray, places: StressPoints) -> np.ndarray:
        """Stress of the linear elements, (n_stress,): the derivative of `stress` at rest."""
        return self.stress(1e-30j * u, places).imag / 1e-30

    def _curvature(self, bend: np.ndarray) -> np.ndarray:
        """Curvature at both ends, (n_e, 2): what bends the section, without what shear turns it by."""
        moments = np.einsum("eij,ej->ei", self.law[:, 1:, 1:], bend)
        return moments * [-1, 1] / self.made_of.bending_stiffness


def _outer(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, :, None] * b[:, None, :]


def _angle(cosine: np.ndarray, sine: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Angle with this cosine and sine that is nearest to `near`; differentiable by complex steps."""
    angle = np.arctan2(np.real(sine), np.real(cosine))
    turns = np.round((np.real(near) - angle) / (2 * np.pi))
    return angle + np.arcsin(sine * np.cos(angle) - cosine * np.sin(angle)) + 2 * np.pi * turns


FIRST_STEP, SMALLEST_STEP = 0.1, 1e-3
"""Parts of the load: the steps, halved where Newton fails or finds an unstable state, and where they are not halved any more."""
ITERATIONS = 40
HELD_STIFFNESS = 1e3
"""Stiffness of a held direction, in parts of that of the stiffest: its square is far from round-off and from any of the body."""
CORRECTION_TOLERANCE, ROUND_OFF = 1e-10, 1e-6
"""Corrections, in parts of the body's size, that Newton is content with: at once; or when they shrink no more."""


def solve_corotational(frame: Corotational, loads: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Displacements (n,) under loads F (n,), reached from zero; their directions stay.

    Parameters
    ----------
    held : (3, n), C

    Raises
    ------
    InputError
        No equilibrium is found up to the full load: the body buckles or snaps through before.
    """
    u, factor, step = np.zeros(len(loads)), 0.0, FIRST_STEP
    while factor < 1 - 1e-12:
        target = min(1.0, factor + step)
        found = _newton(frame, target * loads, held, u)
        if found is None:
            step /= 2
            if step < SMALLEST_STEP:
                raise InputError(
                    f"the corotational body finds no equilibrium beyond {100 * factor:.1f} % of its forces: it buckles or snaps "
                    "through there, which the linear body does not know. Check the scene with smaller loads."
                )
            continue
        u, factor = found, target
    return u


def _newton(frame: Corotational, loads: np.ndarray, held: np.ndarray, u: np.ndarray) -> np.ndarray | None:
    """The equilibrium next to u; None if the iteration does not find it, or it is unstable."""
    size, before = np.ptp(frame.nodes, axis=0).max(), np.inf
    for _ in range(ITERATIONS):
        try:
            correction = BorderedFrame.of(frame.tangent(u), held).solve(loads - frame.force(u))
        except RuntimeError:  # an exactly singular tangent
            return None
        u = u + correction
        change = np.hypot(correction[0::3], correction[1::3]).max()
        if change <= CORRECTION_TOLERANCE * size or (change <= ROUND_OFF * size and change > before / 2):
            return u if _stable(frame.tangent(u), held) else None
        if not change < 1e3 * size:
            return None
        before = change
    return None


def _stable(stiffness: scipy.sparse.csc_array, held: np.ndarray) -> bool:
    """Whether K is positive definite in all directions that the rows C leave free: K + C^T C is, with C made stiff."""
    scale = _scale(stiffness)
    border = held * scale
    stiff = HELD_STIFFNESS * border / np.linalg.norm(border, axis=1)[:, None]
    try:
        np.linalg.cholesky(scale[:, None] * stiffness.toarray() * scale + stiff.T @ stiff)
    except np.linalg.LinAlgError:
        return False
    return True


def _scale(stiffness: scipy.sparse.csc_array) -> np.ndarray:
    """Scales of the unknowns that make the diagonal of K one: a skin is far stiffer in tension than in bending."""
    return 1 / np.sqrt(np.abs(stiffness.diagonal()))


@dataclass(frozen=True)
class BorderedFrame:
    """Factors of [K C^T; C 0] in scaled unknowns."""

    factors: Any
    scale: np.ndarray

    @classmethod
    def of(cls, stiffness: scipy.sparse.csc_array, held: np.ndarray) -> BorderedFrame:
        """Factor a symmetric K (n, n) held by the rows C (m, n)."""
        scale = _scale(stiffness)
        border = held * scale
        border = scipy.sparse.csc_array(border / np.linalg.norm(border, axis=1)[:, None])
        spread = scipy.sparse.diags_array(scale)
        return cls(
            scipy.sparse.linalg.splu(
                scipy.sparse.block_array([[spread @ stiffness @ spread, border.T], [border, None]], format="csc")
            ),
            scale,
        )

    def solve(self, loads: np.ndarray) -> np.ndarray:
        """Displacements (n,) under loads (n,) with C u = 0."""
        rest = np.zeros(self.factors.shape[0] - len(loads))
        return self.scale * self.factors.solve(np.concatenate([self.scale * loads, rest]))[: len(loads)]


@dataclass(frozen=True)
class Comparison:
    """Linear against corotational elements at one instant, beside the meter's estimate; lengths and stresses in the scene's units."""

    estimate: Deformation
    error: float  # largest distance of a node between the two
    stress: float  # largest magnitude, linear
    corotational_stress: float
    stress_error: float  # largest difference at a stress point

    @property
    def relative(self) -> float:
        """The error in parts of the largest linear displacement."""
        return self.error / self.estimate.displacement if self.estimate.displacement else 0.0


class Compared(NamedTuple):
    """Linear displacements and stresses of a body, and those of corotational elements under the same forces."""

    displacements: np.ndarray  # (n,)
    corotational: np.ndarray  # (n,)
    stress: np.ndarray  # (n_stress,)
    corotational_stress: np.ndarray  # (n_stress,)

    @property
    def error(self) -> float:
        """Largest distance of a node between the two."""
        away = self.corotational - self.displacements
        return float(np.hypot(away[0::3], away[1::3]).max())


def compare_with_corotational(solution: Solution, body: str) -> Comparison:
    """Solve a flexible body corotationally at the instant of the largest estimated error.

    Raises
    ------
    InputError
        The reduced model does not hold its finite elements; or the corotational body has no equilibrium under the forces.
    """
    scene = solution.system.scene
    behind = chain(scene, body)
    places = design_point(scene, body, "stress").model.stress
    if not isinstance(behind, PlanarChain) or places is None:
        raise InputError(_without_beams(scene, body))
    estimate = deformation_of(behind, solution, body)
    instant = np.flatnonzero(solution.times == estimate.time)[:1]
    elastic = np.real(solution.q[instant][:, elastic_coordinates(solution, body)])
    held_back = kept_back(solution, body, instant)
    linear = behind.displacements(elastic)[0]
    loaded = linear if held_back is None else behind.displacements(elastic + held_back)[0]
    try:
        found = compared(behind, places, linear, loaded)
    except InputError as error:
        raise InputError(f"body {body!r} at t = {estimate.time:g}: {error}") from None
    sizes = (np.abs(found.stress), np.abs(found.corotational_stress), np.abs(found.corotational_stress - found.stress))
    return Comparison(estimate, found.error, *(float(each.max()) for each in sizes))


def compared(behind: PlanarChain, places: StressPoints, linear: np.ndarray, loaded: np.ndarray) -> Compared:
    """Solve the elements behind a body corotationally, under the forces that its linear elements need for displacements.

    The forces F = K u are those of joints, loads and, in motion, inertia and damping of the body, as far as its basis resolves them, in
    the directions that they have in the body's frame.

    Parameters
    ----------
    linear, loaded : (n,)
        Linear displacements, and the u of the forces: the same without what a spin of the body keeps back.

    Raises
    ------
    InputError
        No corotational equilibrium exists under these forces.
    """
    frame = Corotational(behind.nodes, behind.connectivity, behind.made_of)
    at_rest = frame.tangent(np.zeros(len(linear)))
    found = solve_corotational(frame, at_rest @ loaded, behind.held)
    return Compared(linear, found, frame.linear_stress(linear, places), frame.stress(found, places))


def flexible_of(solution: Solution) -> list[str]:
    """Flexible bodies of a solution.

    Raises
    ------
    InputError
        There is none.
    """
    found = flexible_bodies(solution.system.scene)
    if not found:
        raise InputError("no body of the scene is flexible, so that none deforms. Give a scene with a flexible body.")
    return found


def _without_beams(scene: ResolvedScene, body: str) -> str:
    """Why there is nothing to compare a body with."""
    if not scene.space.turning_elements or scene.model(flexible_body(scene, body).model, "outline").outline is not None:
        return (
            f"body {body!r} does not consist of beams, the only elements that turn here. Compare it with several bodies in a "
            f"row instead of one, which turn themselves{_in_pieces(scene)}."
        )
    return (
        f"the reduced model of body {body!r} does not hold its mesh and stress points, so that its elements are unknown. Build it "
        "again with ffrf-preprocess."
    )


def _in_pieces(scene: ResolvedScene) -> str:
    """How a solid becomes several bodies without being several ones."""
    return (
        ", or with itself cut into pieces ([pieces] in its file) and `frames` in the scene"
        if not scene.space.turning_elements
        else ""
    )
