"""A scene whose reduced bodies have all coordinates: which shapes were left out, and how far they change vibrations.

A scene whose cut bodies are reduced beside the same scene with all coordinates: where the parts of one are in the other.

Some force r_i is left there at the coordinates i that a part does not keep. At rest it would move these by

    delta_i = -(K_ii^-1 - Phi (Phi^T K_ii Phi)^-1 Phi^T) r_i

in shapes that were left out.

Vibrations of a scene whose cut bodies are reduced, in so many more shapes that they are those of all coordinates.

About the state that the reduced scene has come to, every part keeps, besides its own shapes, all modes with its kept coordinates held that
are slower than `LEFT_OUT_FREQUENCY_RATIO` the fastest vibration that is asked for. What is then left out makes frequencies too
high by less than 3e-4 (measured), and none is missing, so that their numbers are those of all coordinates."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from toolkit.components.bodies.cut_body import CutBody
from toolkit.components.bodies.framed_part import FramedPart, whole_design
from toolkit.foundation.verdict import Caution
from toolkit.reduced_model.cut_chain import PartShapes
from toolkit.reduced_model.cut_part import ChainPart
from toolkit.responses.pencil import Pencil, free_pencil
from toolkit.responses.vibration import DampingRatio, OfVibration, any_pencil_of
from toolkit.scene.resolution import ResolvedScene
from toolkit.solvers.free_motions import all_frequencies, all_roots, undamped_rates
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene

SAME_SHAPE = 1e-6
"""Relative difference of a shape from others up to which it is one of them."""


@dataclass(frozen=True)
class ReducedPart:
    """One part with all coordinates, the shapes that are kept of it, and its rows in the full scene."""

    part: ChainPart
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
        basis = scipy.linalg.orth(every / np.sqrt((every**2).sum(axis=0)), SAME_SHAPE)
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


LEFT_OUT_FREQUENCY_RATIO = 10.0
"""Frequency of the slowest shape that is left out, in parts of that of the vibration."""


def richer_pencil(solution: Solution, fastest: float) -> tuple[Pencil, np.ndarray]:
    """Stiffness with multipliers, damping and mass about the last state (n, n), and what makes its coordinates comparable (n_q,).

    Parameters
    ----------
    solution
        Of a scene in which something is reduced.
    fastest
        The fastest vibration that is asked for, in rad/time.
    """
    full = full_scene_of(solution)
    assert full is not None
    system, n_q = full.system, full.system.n_q
    shapes = full.expansion(lambda part: part.richer(LEFT_OUT_FREQUENCY_RATIO * fastest))
    columns = scipy.sparse.csr_array(scipy.sparse.block_diag([shapes, scipy.sparse.eye_array(system.n - n_q)]))
    found = Pencil(*(columns.T @ np.real(each) @ columns for each in any_pencil_of(full.last_state(solution))))
    return found, np.asarray((abs(shapes) * system.weights[:n_q, None]).max(axis=0).todense()).ravel()


REMARK_PART, DOUBT_PART = 0.01, 0.05
"""Parts of a frequency by which it may be too high without a word, and without a doubt."""
MOST_NAMED = 10
"""So many frequencies are named one by one; of a longer list the one that is off most is named besides."""


def raised_frequencies(solution: Solution, frequencies: np.ndarray) -> np.ndarray:
    """Parts (n_modes,) by which the lowest frequencies about the last state are too high, in cycles per time; zero of those that do not
    vibrate, inf of those in the place of one that does not."""
    found, vibrating = np.zeros(len(frequencies)), frequencies > 0
    if not vibrating.any() or not reduced_bodies(solution.system.scene):
        return found
    pencil, weights = richer_pencil(solution, 2 * np.pi * frequencies.max())
    reduced = free_pencil(weights, pencil)[1]
    if solution.spins:
        true = all_frequencies(all_roots(*reduced)[0])
    else:
        true = undamped_rates(reduced.stiffness, reduced.mass) / (2 * np.pi)
    true = true[: len(found)][vibrating]
    with np.errstate(divide="ignore"):
        found[vibrating] = frequencies[vibrating] / np.maximum(true, 0.0) - 1
    return found


def cautions_of_raised(solution: Solution, frequencies: np.ndarray) -> Iterator[Caution]:
    """All of the frequencies that are too high."""
    parts = {f"number {k + 1}": float(part) for k, part in enumerate(raised_frequencies(solution, frequencies))}
    high = {name: part for name, part in parts.items() if abs(part) > REMARK_PART}
    if high:
        yield Caution(
            "left-out-shapes",
            "the parts of cut bodies keep some of their modes (modes_per_frame), so that frequencies are too high, or missing: "
            f"{listed_parts(high, 'about')}. Those before {next(iter(high))} are so by less than {REMARK_PART:.0%}. Write "
            "larger numbers, or "
            "leave them out.",
            doubt=max(map(abs, high.values())) > DOUBT_PART,
        )


def listed_parts(parts: Mapping[str, float], word: str) -> str:
    """Frequencies, by what they are called, and the parts by which they are too high, in words."""
    first, most = list(parts)[:MOST_NAMED], max(parts, key=lambda name: abs(parts[name]))
    told = [f"{name} by {word} {parts[name]:.1%}" for name in (*first, *({most} - {*first}))]
    more = len(parts) - len(told)
    return ", ".join(told) + (f", and {more} more" if more else "")


DAMPING_ROUND_OFF = 1e-9
"""Damping ratio that is round-off."""
FREE_MOTION_PART = 1e-6
"""Part of the fastest vibration below which a vibration is round-off: a motion that nothing holds."""
SWAPPING_DISTANCE, ALLOWED_DIFFERENCE = 0.01, 3e-4
"""Parts of a frequency by which two vibrations differ at most that may change places, if it is off by as much; and which it may always be
off by, see `richer_pencil`."""


def changed_vibrations(solution: Solution) -> dict[str, float]:
    """Response -> relative error of its vibration by left-out shapes; empty where nothing is reduced, without undamped ones.

    Of vibrations that are so close to each other that they may change places, the largest of their errors counts.
    """
    scene, n_q = solution.system.scene, solution.system.n_q
    asked = {name: each for name, each in scene.responses.items() if isinstance(each, OfVibration)}
    asked = {name: each for name, each in asked.items() if not (solution.steps and each.needs_rest)}
    if not asked or not reduced_bodies(scene):
        return {}
    pencil, weights = any_pencil_of(solution), solution.system.weights[:n_q]
    found = {name: each.vibrations(solution, pencil, weights)[each.number - 1] for name, each in asked.items()}
    richer = richer_pencil(solution, max(map(abs, found.values())))
    told = {name: _part(each, found[name], each.vibrations(solution, *richer)) for name, each in asked.items()}
    return {name: part for name, part in told.items() if not np.isnan(part)}


def _part(response: OfVibration, s: complex, true: np.ndarray) -> float:
    """Relative error of the number from s, against those near its place among the true ones; the largest counts.

    It is nan where both are zero, and inf where only the true numbers are, or where there is none of its place.
    """
    if response.number > len(true):
        return np.inf
    wanted = true[response.number - 1]
    reach = np.clip(abs(s - wanted), ALLOWED_DIFFERENCE * abs(wanted), SWAPPING_DISTANCE * abs(wanted))
    numbers = np.array([response.of(each) for each in true[np.abs(true - wanted) <= reach]])
    zero = DAMPING_ROUND_OFF if isinstance(response, DampingRatio) else FREE_MOTION_PART * np.abs(true).max() / (2 * np.pi)
    value = response.of(s)
    if np.abs(numbers).min() <= zero:
        return np.nan if abs(value) <= zero else np.inf
    parts = (value - numbers) / np.abs(numbers)
    return float(parts[np.argmax(np.abs(parts))])


def cautions_of_changed(solution: Solution) -> Iterator[Caution]:
    """A caution about all responses whose vibrations left-out shapes change by much."""
    parts = {name: part for name, part in changed_vibrations(solution).items() if abs(part) > REMARK_PART}
    if parts:
        yield Caution(
            "left-out-shapes",
            "the parts of cut bodies keep some of their modes (modes_per_frame), which changes "
            f"{', '.join(f'{name} by about {part:+.1%}' for name, part in parts.items())}. Write larger numbers, or leave them out.",
            doubt=bool(max(map(abs, parts.values())) > DOUBT_PART),
        )
