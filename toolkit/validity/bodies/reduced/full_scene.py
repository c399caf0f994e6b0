"""A scene whose cut bodies are reduced beside the same scene with all coordinates: where the parts of one are in the other.

Some force r_i is left there at the coordinates i that a part does not keep. At rest it would move these by

    delta_i = -(K_ii^-1 - Phi (Phi^T K_ii Phi)^-1 Phi^T) r_i

in shapes that were left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart, whole_design
from toolkit.reduced_model.cut.craig_bampton import PartShapes
from toolkit.reduced_model.cut.part import Part
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

SAME = 1e-6
"""Relative difference of a shape from others up to which it is one of them."""


@dataclass(frozen=True)
class ReducedPart:
    """One part with all coordinates, the shapes that are kept of it, and its rows in the full scene."""

    part: Part
    shapes: PartShapes
    rows: slice  # of its elastic coordinates

    @property
    def columns(self) -> np.ndarray:
        """Columns of all elastic coordinates per reduced one."""
        return self.shapes.columns(self.part.invariants.stiffness)

    @property
    def inner(self) -> np.ndarray:
        """Numbers of the elastic coordinates (n_i,) that are not kept."""
        return np.delete(np.arange(self.part.n_f), self.shapes.kept)

    def moved(self, forces: np.ndarray) -> np.ndarray:
        """Displacements -delta (n_t, n_f) in left-out shapes under forces r (n_t, n_f)."""
        inner, found = self.inner, np.zeros_like(forces)
        own, phi = self.part.invariants.stiffness[np.ix_(inner, inner)], self.shapes.modes
        if inner.size:
            held = forces[:, inner].T
            found[:, inner] = (
                scipy.sparse.linalg.splu(scipy.sparse.csc_array(own)).solve(held)
                - phi @ np.linalg.solve(phi.T @ own @ phi, phi.T @ held)
            ).T
        return found

    def richer(self, fastest: float) -> np.ndarray:
        """Columns of the part (n_f, n) with all modes slower than `fastest`, in rad/time, the kept coordinates held."""
        inner, kept, columns = self.inner, len(self.shapes.kept), self.columns
        if not inner.size:
            return columns
        inv, own = self.part.invariants, np.ix_(inner, inner)
        mass = inv.inertia_about_origin[1:, 1:][own]
        squares, modes = scipy.linalg.eigh(inv.stiffness[own], mass)
        factor = scipy.linalg.cholesky(mass)
        every = factor @ np.column_stack([modes[:, squares < fastest**2], self.shapes.modes])
        basis = scipy.linalg.orth(every / np.sqrt((every**2).sum(axis=0)), SAME)
        inside = np.zeros((len(columns), basis.shape[1]))
        inside[inner] = scipy.linalg.solve_triangular(factor, basis)
        return np.column_stack([columns[:, :kept], inside])


@dataclass(frozen=True)
class FullScene:
    """The scene with all coordinates of the bodies that are reduced."""

    system: System
    parts: dict[str, dict[str, ReducedPart]]  # of every such body, by name

    @cached_property
    def expanded(self) -> scipy.sparse.csr_array:
        """Coordinates of the full scene per coordinate of the reduced scene, (n_q, n_q)."""
        return self.expansion(lambda part: part.columns)

    def expansion(self, columns: Callable[[ReducedPart], np.ndarray]) -> scipy.sparse.csr_array:
        """Coordinates of the full scene per coordinate of a scene whose parts have these columns (n_f, n)."""
        parts = {name: each for own in self.parts.values() for name, each in own.items()}
        blocks, first = [], [*self.system.numbering.first.items()]
        for (name, start), (_, end) in zip(first, [*first[1:], ("", self.system.n_q)], strict=True):
            blocks.append(scipy.sparse.eye_array((parts[name].rows.start if name in parts else end) - start))
            if name in parts:
                blocks.append(scipy.sparse.csr_array(columns(parts[name])))
        return scipy.sparse.csr_array(scipy.sparse.block_diag(blocks))

    def last_state(self, solution: Solution) -> Solution:
        """State that a run of the reduced scene ends in, in the coordinates of the full scene."""
        n_q, states = self.system.n_q, np.zeros((3, 1, self.system.n))
        states[:, 0, :n_q] = [self.expanded @ each[-1] for each in (solution.q, solution.v, solution.a)]
        states[2, 0, n_q:] = solution.multipliers[-1]
        run = {"options": solution.options, "run_times": solution.whole_run}
        none = np.zeros((1, self.system.n, 0))
        return Solution.from_padded(self.system, solution.times[-1:], (*states, none, none, none), **run)


def full_scene_of(solution: Solution) -> FullScene | None:
    """Full scene of a run, made when first asked for; None if nothing is reduced."""
    if FullScene not in solution.known:
        solution.known[FullScene] = full_scene(solution.system.scene)
    found: FullScene | None = solution.known[FullScene]
    return found


def reduced_bodies(scene: ResolvedScene) -> dict[str, CutBody]:
    """Cut bodies whose parts do not keep all coordinates."""
    cut = {name: body for name, body in scene.bodies.items() if isinstance(body, CutBody)}
    return {name: body for name, body in cut.items() if body.modes_per_frame is not None}  # type: ignore[attr-defined]


def full_scene(scene: ResolvedScene) -> FullScene | None:
    """The scene with all coordinates of its reduced bodies; None if nothing is reduced."""
    bodies = reduced_bodies(scene)
    if not bodies:
        return None
    plain = scene.written
    changed = {name: plain.bodies[name].model_copy(update={"modes_per_frame": None}) for name in bodies}
    system = compile_scene(plain.model_copy(update={"bodies": {**plain.bodies, **changed}}))
    return FullScene(system, {name: _parts(scene, system, name, body) for name, body in bodies.items()})


def _parts(scene: ResolvedScene, full: System, name: str, body: CutBody) -> dict[str, ReducedPart]:
    """Reduced parts of one body by name."""
    found, every = {}, full.scene.all_bodies()
    for part_name, reduced in body.parts(name).items():
        whole = every[part_name]
        assert isinstance(reduced, FramedPart)
        assert isinstance(whole, FramedPart)
        part, shapes = whole.part(full.scene), reduced.shapes(whole_design(scene, name).model)
        assert shapes is not None
        start = full.numbering.first[part_name] + whole.frame_coordinates
        found[part_name] = ReducedPart(part, shapes, slice(start, start + part.n_f))
    return found
