"""What one system evaluates its equations with: memory, formulas, records, curves, and sums of a backward run.

Records of a system as compiled code takes them, each made once; and scratch memory, which one run takes over from another.

To reserve memory and to tell compiled code where it is takes as long as some steps of a small mechanism.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
import scipy

from toolkit.components.bodies.kernels.constant_kernel import Changes
from toolkit.components.joints.kernels.laws import SIGNATURE as LAW_SIGNATURE
from toolkit.components.joints.kernels.laws import angle_law
from toolkit.components.joints.kernels.records import DESIGN, DESIGNED, PINNED
from toolkit.components.loads.kernels.load_kernel import SIGNATURE as LOAD_SIGNATURE
from toolkit.components.loads.torque import torque
from toolkit.components.markers.planar import Markers
from toolkit.foundation.compiled.calls import in_memory
from toolkit.foundation.errors import InputError
from toolkit.foundation.kernel import plain, slots
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene
from toolkit.system.equations import DesignSums, GatheredPlan, Plan, Terms, allocate_terms, allocate_work, of_variables
from toolkit.system.joint_arrays import families, laws_of
from toolkit.system.numbering import starts
from toolkit.system.plan import touched
from toolkit.system.quantities import loads_of


class EvaluationMemory(threading.local):
    """Memory in which one thread evaluates the equations of a system; every thread has its own.

    Parameters
    ----------
    plan
        Of the system, whose formulas run compiled.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan, self._terms = plan, allocate_terms(plan, float)
        self._state = np.zeros((3, plan.n))
        self._touched = plan.touched_variable * len(self._terms.I_x) + plan.touched_row
        self.terms: Any = in_memory(self._terms)
        work = allocate_work(plan, float)
        self.work: Any = in_memory(work)
        self.care = work.care
        """Care with which it is evaluated, see `Work`."""
        self.formula: Callable[..., Any] | None = None
        """The compiled equations, once they have been looked up."""

    def state(self, *vectors: np.ndarray) -> np.ndarray:
        """q, v and acc (n,) as the compiled equations take them."""
        self._state[:] = vectors
        return self._state

    def found(self, linearized: bool, designed: bool) -> Terms:
        """Copy of the terms that the last evaluation has found; those that it was not asked for are zero."""
        known = self._terms
        by_state = known.I_acc, known.I_q, known.A_q, known.A_v
        I_acc, I_q, A_q, A_v = [each.copy() for each in by_state] if linearized else np.zeros((4, len(known.I_acc)))
        by_design = np.zeros(known.I_x.shape, order="F"), np.zeros(known.A_x.shape, order="F")  # memory that nobody reads
        found = Terms(known.inertial.copy(), known.applied.copy(), I_acc, I_q, A_q, A_v, *by_design)
        if designed:  # few entries by each variable
            for to, of in ((found.I_x, known.I_x), (found.A_x, known.A_x)):
                np.put(to.T, self._touched, np.take(of.T, self._touched))
        return of_variables(self._plan, found)

    def applied_touched(self) -> np.ndarray:
        """Derivatives of the applied terms by the design that the last evaluation has found, at the entries that the plan names."""
        return np.take(self._terms.A_x.T, self._touched)


def _formulas(scene: ResolvedScene) -> tuple[list, list]:
    """Open formulas of the scene's joints, each once, and formulas of its loads; there is always one of each."""
    return laws_of(list(scene.joints.values())) or [angle_law], families(loads_of(scene)) or [torque]


def formulas_of(scene: ResolvedScene) -> tuple[tuple, tuple]:
    """Formulas of the scene's joints and loads, ready for the compiled loop."""
    joints, loads = _formulas(scene)
    return slots(joints, LAW_SIGNATURE), slots(loads, LOAD_SIGNATURE)


def plain_formulas_of(scene: ResolvedScene) -> tuple[tuple, tuple]:
    """Formulas of the scene's joints and loads as plain Python."""
    joints, loads = _formulas(scene)
    return tuple(map(plain, joints)), tuple(map(plain, loads))


R = TypeVar("R")


class HandedRecords:
    """Parts of a system, which never change, as compiled code takes them, and scratch memory that is not in use.

    Parameters
    ----------
    parts
        Of the system; whatever is no tuple is handed on as it is.
    """

    def __init__(self, parts: Iterable[object]) -> None:
        self._packed: dict[int, Any] = {id(part): None for part in parts if isinstance(part, tuple)}
        self._spare: dict[Hashable, list[Any]] = {}

    def take(self, part: object) -> None:
        """Know another record, which has to live as long as the system."""
        self._packed[id(part)] = None

    def of(self, given: object) -> object:
        """Argument in the form that compiled code takes, if it is known here; else the argument itself."""
        known = id(given)
        if known not in self._packed:
            return given
        if self._packed[known] is None:
            self._packed[known] = in_memory(given)
        return self._packed[known]

    def scratch(self, key: Hashable, make: Callable[[], R]) -> R:
        """A record of scratch memory, whatever it holds: one that was given back under the key, or else a new one."""
        try:
            packed = self._spare[key].pop()
        except (KeyError, IndexError):
            packed = in_memory(make())
        self._packed[id(packed.record)] = packed
        found: R = packed.record
        return found

    def give_back(self, key: Hashable, record: object) -> None:
        """Keep a record of `scratch` for the next one that asks."""
        self._spare.setdefault(key, []).append(self._packed.pop(id(record)))

    def share_spare(self, other: HandedRecords) -> None:
        """Have the scratch memory of another system, whose arrays have the same shapes."""
        self._spare = other._spare

    def shares_spare(self, other: HandedRecords) -> bool:
        """Whether it has the scratch memory of another system."""
        return self._spare is other._spare


REMEMBERED_TIMES, LARGEST_REMEMBERED_SET = 4, 100_000
"""Sets of times whose curves a system remembers: the start, the end and the steps of a run; and most numbers of such a set, as longer runs
take so long that curves are nothing beside them."""

Known = dict[tuple[str, bytes], np.ndarray]
"""Times, by their type and bytes -> what curves are there."""


def remembered(known: Known, times: np.ndarray, evaluate: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Values that are known at these times, or else are evaluated and known from now on.

    It is a copy, which may be written to.
    """
    key = times.dtype.str, times.tobytes()
    found = known.get(key)
    if found is None:
        found = evaluate(times)
        if len(known) >= REMEMBERED_TIMES:
            known.clear()
        if found.size <= LARGEST_REMEMBERED_SET:
            known[key] = found
    return found.copy()


FileStates = Mapping[Path, tuple[int, int] | None]
"""File -> when it was written, in ns, and its size; None if it was not there."""


def file_states(scene: Scene) -> FileStates:
    """Present states of all files that a scene names, those of reduced models and of a kept start."""
    return {path: _state(path) for path in scene.read_files()}


def refuse_changed(states: FileStates) -> None:
    """Refuse to go on where a file is not in the state that it was in.

    Raises
    ------
    InputError
        Names the file: half of the numbers would be those of another body.
    """
    for path, state in states.items():
        if _state(path) != state:
            raise InputError(
                f"the file {str(path)!r} has changed since the scene was compiled, or is not there any more, so that half of the "
                "numbers would be those of another body, or of another start. Compile the scene again."
            )


def _state(path: Path) -> tuple[int, int] | None:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


class GatheredDesign(NamedTuple):
    """A plan whose variables change only what is not gathered, and the plan of what is gathered."""

    plan: Plan
    gathered: GatheredPlan
    moves: scipy.sparse.csr_array  # (n_x, 2 n_m + 2 n_columns) derivatives of points and shapes of markers by the variables

    def gradient(self, sums: DesignSums) -> np.ndarray:
        """Gradient (n_x, n_r) that follows from the sums."""
        n_r = sums.points.shape[2]
        return sums.gradient[:, :n_r] + self.moves @ np.concatenate([sums.points, sums.shapes]).reshape(-1, n_r)


def gathered_design(plan: Plan) -> GatheredDesign:
    """Plan of a backward run that gathers changes of matrices, and of points that nothing but pins grip."""
    constant, markers, own = plan.constant, plan.markers, _gripped_by_pins(plan)
    changes = constant.design_mass, constant.design_damping, constant.design_loose
    met = [np.unique(np.concatenate([getattr(each, name) for each in changes])).astype(np.int64) for name in ("row", "column")]
    gathered = GatheredPlan(*changes, *met, *np.nonzero(own[plan.joints.marker]))
    none = Changes(*(np.zeros(size, each.dtype) for size, each in zip((0, 0, 1, 0, 0), changes[0], strict=True)))
    rest: dict[str, Any] = {
        "constant": constant._replace(design_mass=none, design_damping=none, design_loose=none),
        "markers": _without(markers, own) if isinstance(markers, Markers) else markers,
        "joints": plan.joints._replace(of=_designed(plan, own)),
    }
    kept = {name: rest.get(name, getattr(plan, name)) for name in ("floating", "drag", "loads", "pressures", *rest)}
    row, variable = touched(plan.n_x, **kept, curve_index=plan.curve_index, curve_variable=plan.curve_variable)
    return GatheredDesign(plan._replace(**rest, touched_row=row, touched_variable=variable), gathered, _moves(plan, own))


def _gripped_by_pins(plan: Plan) -> np.ndarray:
    """Markers that a variable moves and that nothing grips but pins, whose rows depend on nothing else, (n_m,)."""
    joints, markers = plan.joints, plan.markers
    pins = (joints.of[:, PINNED] == 1) & (joints.of[:, DESIGN] == joints.of[:, DESIGN + 1])
    found: np.ndarray = np.diff(markers.design_start) > 0
    found[np.concatenate([joints.marker[~pins].ravel(), plan.loads.marker.ravel()])] = False
    return found & (plan.markers.plane is not None) & (len(plan.dropped) == 0)


def _designed(plan: Plan, own: np.ndarray) -> np.ndarray:
    """Array `Joints.of`, where pins are left out whose points are gathered."""
    joints, moved = plan.joints, (np.diff(plan.markers.design_start) > 0) & ~own
    of: np.ndarray = joints.of.copy()
    gathered = own[joints.marker].any(axis=1) & ~moved[joints.marker].any(axis=1)
    of[gathered, DESIGNED] = 0
    return of


def _without(markers: Markers, own: np.ndarray) -> Markers:
    """Markers without the design changes of those that are gathered."""
    counts = np.diff(markers.design_start)
    kept = ~np.repeat(own, counts)
    return markers._replace(
        design_start=starts(np.where(own, 0, counts).tolist()),
        design_variable=markers.design_variable[kept],
        design_point=markers.design_point[kept],
        design_shape_start=markers.design_shape_start[kept],
    )


def _moves(plan: Plan, own: np.ndarray) -> scipy.sparse.csr_array:
    """Matrix `GatheredDesign.moves` of the markers that are gathered."""
    markers, counts = plan.markers, np.diff(plan.markers.design_start)
    d = np.flatnonzero(np.repeat(own, counts))
    m, sizes = np.repeat(np.arange(len(own)), counts)[d], np.diff(markers.start)
    before = np.cumsum(sizes[m]) - sizes[m]
    within = np.arange(sizes[m].sum()) - np.repeat(before, sizes[m])
    row, column = (np.repeat(first, sizes[m]) + within for first in (markers.design_shape_start[d], markers.start[m]))
    variable = markers.design_variable[d]
    value = np.concatenate([markers.design_point[d, :2], markers.design_shape[row, :2]])
    place = 2 * np.concatenate([m, len(own) + column])[:, None] + np.arange(2)
    of = np.repeat(np.concatenate([variable, np.repeat(variable, sizes[m])]), 2)
    return scipy.sparse.csr_array(
        (value.ravel(), (of, place.ravel())), shape=(plan.n_x, 2 * (len(own) + len(markers.coordinate)))
    )
