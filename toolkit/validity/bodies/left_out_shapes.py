"""What parts of a cut body lack that keep some of their shapes only: how far the forces of a run would bend them in the others.

The same scene with all nodal coordinates is put into the states of the run, where its equations are not in balance: some force r_i is left
at the coordinates i that the parts do not keep, inertia included. At rest it would move these by

    delta_i = -(K_ii^-1 - Phi (Phi^T K_ii Phi)^-1 Phi^T) r_i

in shapes that were left out, which is their part in the motion as long as none of them vibrates.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.sparse import block_diag, csr_array, eye_array

from toolkit.bodies.cut.cut_body import CutBody
from toolkit.bodies.cut.framed_part import FramedPart, whole_design
from toolkit.equations.equations import Inputs
from toolkit.foundation.verdict import Caution
from toolkit.reduced_model.cut.craig_bampton import PartShapes
from toolkit.reduced_model.cut.part import Part
from toolkit.scene.cut_scene import written
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution
from toolkit.system.system import System, compile_scene
from toolkit.validity.bodies.cut.places import STRAIGHT, largest_displacement, undeformed_places
from toolkit.validity.bodies.deformation import LIMIT

INSTANTS = 20
"""States of a run that are looked at."""


@dataclass(frozen=True)
class LeftOut:
    """Of one body, the largest at any of the instants."""

    displacement: float  # of a node, in parts of the largest displacement of the body
    stress: float  # in parts of its largest stress


@dataclass(frozen=True)
class _Reduced:
    """One part of a reduced body: with all coordinates, what it keeps of them, and where it is among those of the full scene."""

    part: Part
    shapes: PartShapes
    rows: slice  # of its elastic coordinates

    @property
    def columns(self) -> np.ndarray:
        """All elastic coordinates per reduced one."""
        return self.shapes.columns(self.part.invariants.stiffness)

    def moved(self, forces: np.ndarray) -> np.ndarray:
        """Elastic coordinates (n_t, n_f) in the shapes that were left out, under forces (n_t, n_f) at rest."""
        stiffness = self.part.invariants.stiffness
        inner = np.delete(np.arange(len(stiffness)), self.shapes.kept)
        own, phi, found = stiffness[np.ix_(inner, inner)], self.shapes.modes, np.zeros_like(forces)
        if inner.size:
            held = forces[:, inner].T
            found[:, inner] = (np.linalg.solve(own, held) - phi @ np.linalg.solve(phi.T @ own @ phi, phi.T @ held)).T
        return found


def left_out_shapes(solution: Solution) -> dict[str, LeftOut]:
    """What every body lacks whose parts do not keep all coordinates."""
    bodies = _reduced_bodies(solution.system.scene)
    if not bodies:
        return {}
    if LeftOut not in solution.known:
        full = _full(solution.system.scene, bodies)
        parts = {name: _parts(solution.system.scene, full, name, body) for name, body in bodies.items()}
        forces = _unbalanced(solution, full, {name: each for of_body in parts.values() for name, each in of_body.items()})
        solution.known[LeftOut] = {name: _of_body(solution, name, [*parts[name].values()], forces) for name in bodies}
    found: dict[str, LeftOut] = solution.known[LeftOut]
    return found


def shapes_missed(solution: Solution) -> Iterator[Caution]:
    """Bodies whose parts keep too few shapes."""
    for name, found in left_out_shapes(solution).items():
        if max(found.displacement, found.stress) > LIMIT:
            modes = solution.system.scene.bodies[name].modes_per_frame  # type: ignore[attr-defined]
            yield Caution(
                "left-out-shapes",
                f"the parts of {name} keep {modes} {'mode' if modes == 1 else 'modes'} each: those that were left out would move it by "
                f"{found.displacement:.1%} of its largest displacement and change its stress by {found.stress:.1%} of the largest (limit "
                f"{LIMIT:.0%}). Write a larger bodies.{name}.modes_per_frame, or leave it out to keep all coordinates.",
            )


def shapes_measured(solution: Solution) -> dict[str, Any]:
    """Body -> what its parts lack, as a record."""
    return {name: asdict(each) for name, each in left_out_shapes(solution).items()}


def _reduced_bodies(scene: Scene) -> dict[str, CutBody]:
    cut = {name: body for name, body in scene.bodies.items() if isinstance(body, CutBody)}
    return {name: body for name, body in cut.items() if body.modes_per_frame is not None}  # type: ignore[attr-defined]


def _full(scene: Scene, bodies: Mapping[str, CutBody]) -> System:
    """The scene with all coordinates of these bodies."""
    plain = written(scene)
    changed = {name: plain.bodies[name].model_copy(update={"modes_per_frame": None}) for name in bodies}
    return compile_scene(plain.model_copy(update={"bodies": {**plain.bodies, **changed}}))


def _parts(scene: Scene, full: System, name: str, body: CutBody) -> dict[str, _Reduced]:
    """Those of one body by name."""
    found, every = {}, full.scene.all_bodies()
    for part_name, reduced in body.parts(name).items():
        whole = every[part_name]
        assert isinstance(reduced, FramedPart)
        assert isinstance(whole, FramedPart)
        part, shapes = whole.part(full.scene), reduced.shapes(whole_design(scene, name).model)
        assert shapes is not None
        start = full.numbering.first[part_name] + whole.frame_coordinates
        found[part_name] = _Reduced(part, shapes, slice(start, start + part.n_f))
    return found


def _unbalanced(solution: Solution, full: System, parts: Mapping[str, _Reduced]) -> np.ndarray:
    """What is left of the forces at the coordinates of the full scene, (n_t, n_q), in some states of the run."""
    n = np.unique(np.linspace(0, len(solution.times) - 1, INSTANTS).round().astype(int))
    expanded = _expansion(solution, full, parts)
    states: np.ndarray = np.zeros((3, len(n), full.n))
    for state, known in zip(states, (solution.q, solution.v, solution.a), strict=True):
        state[:, : full.n_q] = known[n] @ expanded.T
    states[2, :, full.n_q :] = solution.multipliers[n]
    inertia = not (solution.options or solution.system.scene.solver).quasi_static
    curves = full.curve_values(solution.times[n])
    left = np.zeros((len(n), full.n_q))
    for k, (q, v, acc) in enumerate(zip(*states, strict=True)):
        inputs = Inputs(curves[k], np.zeros((0, 3)), 1.0, np.zeros(3), inertia, False)
        terms = full.evaluate(inputs, q, v, acc, linearize=False)
        left[k] = (terms.inertial + terms.applied)[: full.n_q]
    return left


def _expansion(solution: Solution, full: System, parts: Mapping[str, _Reduced]) -> csr_array:
    """Coordinates of the full scene per coordinate of the run, (n_q, n_q)."""
    blocks, first = [], [*full.numbering.first.items()]
    for (name, start), (_, end) in zip(first, [*first[1:], ("", full.n_q)], strict=True):
        elastic = parts[name].rows if name in parts else slice(end, end)
        blocks.append(eye_array(elastic.start - start))
        if name in parts:
            blocks.append(csr_array(parts[name].columns))
    return csr_array(block_diag(blocks))


def _of_body(solution: Solution, name: str, parts: list[_Reduced], forces: np.ndarray) -> LeftOut:
    scene = solution.system.scene
    body: Any = scene.bodies[name]
    moved = [part.moved(forces[:, part.rows]) for part in parts]
    away = max(_farthest(part.part, elastic) for part, elastic in zip(parts, moved, strict=True))
    displacement = largest_displacement(solution, name)
    stress = np.abs(solution.q[:, elastic_coordinates(solution, name)] @ body.stress_operator(scene).reshape(-1, _width(body)).T)
    changed = [
        np.abs(elastic @ part.part.invariants.stress_operator.reshape(-1, part.part.n_f).T).max(initial=0.0)
        for part, elastic in zip(parts, moved, strict=True)
    ]
    size = np.ptp(undeformed_places(scene, name), axis=0).max()
    return LeftOut(
        float(away / displacement) if displacement > STRAIGHT * size else 0.0,
        float(max(changed) / stress.max(initial=0.0)) if stress.max(initial=0.0) > 0 else 0.0,
    )


def _width(body: CutBody) -> int:
    return len(body.elastic_places)


def _farthest(part: Part, elastic: np.ndarray) -> float:
    """The largest displacement of a node."""
    d = part.nodes.shape[1]
    moves = (elastic @ np.real(part.recovery[:, 1:]).T).reshape(len(elastic), -1, part.per_node)[:, :, :d]
    return float(np.sqrt((moves * moves).sum(axis=2)).max())
