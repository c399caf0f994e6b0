"""The compiled scene: numbering, plan, functions and start values; made once, never changed."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from typing import TypeVar

import numpy as np
import scipy

from toolkit.description.description import holds_complex
from toolkit.description.design import Design
from toolkit.foundation.compiled.calls import call, entry_point, formula_for, in_memory
from toolkit.foundation.compiled.packed import Formula, Packed
from toolkit.foundation.kernel import plain
from toolkit.foundation.near_ties import first_largest
from toolkit.linear.sparse_analysis import LUPlan, analyse
from toolkit.scene.resolution import ResolvedScene, resolve
from toolkit.scene.scene import Scene
from toolkit.system.equations import (
    Inputs,
    Plan,
    ScratchMemory,
    Terms,
    allocate_terms,
    allocate_work,
    evaluate_all,
    evaluate_states,
    of_variables,
)
from toolkit.system.evaluation import (
    EvaluationMemory,
    FileStates,
    GatheredDesign,
    HandedRecords,
    Known,
    file_states,
    formulas_of,
    gathered_design,
    plain_formulas_of,
    refuse_changed,
    remembered,
)
from toolkit.system.numbering import Numbering, number, weights
from toolkit.system.pattern import moving_unknowns, on_common_pattern
from toolkit.system.plan import build_plan
from toolkit.system.quantities import STEP, Asked, Quantities, check_numbers, derivatives, seen_quantities
from toolkit.system.redundant_joints import without_redundant_rows

R = TypeVar("R")
LOOPED_PRODUCT_TERMS = 10_000
"""Most terms of a product that is summed up here, as beside the work of more of them a call of a library is nothing."""

KEPT_MEMORY_UNKNOWNS = 1000
"""Unknowns up to which the memory of a run is left to the next one."""


@dataclass(frozen=True)
class System:
    """A compiled scene, ready to be solved.

    Real systems run compiled; a system whose scene holds a complex number (see `sensitivity.numerical`) runs the same formulas
    as plain Python. `functions` are the formulas of the joints and loads that the scene uses.
    """

    scene: ResolvedScene
    design: Design
    numbering: Numbering
    plan: Plan
    lu_plan: LUPlan
    values: Quantities
    derivatives: list[Quantities]
    functions: tuple
    dtype: type
    weights: np.ndarray  # (n,) see `numbering.weights`
    files: FileStates = field(default_factory=dict)  # of reduced models, when the scene was compiled
    asked: Asked = field(default_factory=dict)  # of the scene by joints and loads, when it was compiled
    origin: System | None = (
        None  # the same scene at the numbers that it was compiled with, whose compiled equations and memory it uses
    )
    known_curves: Known = field(default_factory=dict)  # at the last times, for all systems that have the same curves

    @property
    def n_q(self) -> int:
        """Number of coordinates."""
        return self.plan.n_q

    @cached_property
    def n_b(self) -> int:
        """Number of coordinates of bodies; behind them come the states of loads, which count among the forces of an equilibrium."""
        return self.n_q - len(self.numbering.states)

    @property
    def n(self) -> int:
        """Number of unknowns: coordinates and multipliers."""
        return self.plan.n

    @property
    def n_x(self) -> int:
        """Number of design variables."""
        return self.plan.n_x

    @property
    def compiled(self) -> bool:
        """Whether the formulas run compiled."""
        return self.dtype is float

    def run(self, function: Callable[..., R], *arguments: object) -> R:
        """Call a kernel as it has to be called for this system: compiled, or as plain Python."""
        if not self.compiled:
            return plain(function)(*arguments)
        return call(function, *map(self._handed.of, arguments))

    def prepared(self, function: Callable[..., R], *arguments: object) -> Callable[[], R]:
        """Kernel with its arguments, looked up once, for whoever writes other numbers into their arrays and calls it again."""
        if not self.compiled:
            return partial(plain(function), *arguments)
        given = [in_memory(self._handed.of(each)) for each in arguments]
        return partial(entry_point(function, *given), *given)

    @cached_property
    def _handed(self) -> HandedRecords:
        """Records of this system, which never change, as compiled code takes them; with the scratch memory of its origin if that fits."""
        found, origin = HandedRecords((self.plan, *self.plan, self.functions, *self.functions)), self.origin
        if origin is None or not self._is_short(found) or not self._touches_as(origin):
            return found
        mine, its = found.of(self.plan), origin._handed.of(origin.plan)
        if isinstance(mine, Packed) and isinstance(its, Packed) and mine.same_shapes(its):
            found.share_spare(origin._handed)
        return found

    @cached_property
    def unit_of_states(self) -> np.ndarray:
        """Ones on the diagonal of the states of loads, by entries of the pattern, which make the mass matrix regular.

        States of loads have no mass.
        """
        if self.origin is not None:
            return self.origin.unit_of_states
        rows = np.repeat(np.arange(self.n), np.diff(self.plan.indptr))
        return np.where((rows == self.plan.indices) & np.isin(rows, self.numbering.states), 1.0, 0.0)

    def evaluate(
        self,
        inputs: Inputs,
        q: np.ndarray,
        v: np.ndarray,
        acc: np.ndarray,
        design: bool = False,
        linearize: bool = True,
        apart: bool = False,
    ) -> Terms:
        """Residual, derivatives by the state and, on request, partial derivatives by the design; q, v, acc (n,).

        Without `linearize` the derivatives by the state are left zero; if `apart` they lack the stiffness that is kept in its factors.
        """
        design = bool(design and self.n_x > 0)
        if not self.compiled:
            terms, work = allocate_terms(self.plan, self.dtype), self.work
            work.care[1] = apart
            self.run(evaluate_all, self.plan, self.functions, inputs, q, v, acc, linearize, design, terms, work)
            return of_variables(self.plan, terms)
        return self._evaluate(inputs, q, v, acc, linearize, design, apart).found(linearize, design)

    def evaluate_states(
        self,
        curves: tuple[np.ndarray, np.ndarray],
        levels: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
        acc: np.ndarray,
        joints_only: bool = False,
    ) -> list[Terms]:
        """Residuals and derivatives by the state of several states, q, v, acc (k, n) with `curves` at their times: in one compiled call."""
        count = len(q)
        residuals: np.ndarray = np.zeros((count, 2, self.n), self.dtype)
        values: np.ndarray = np.zeros((count, 4, len(self.plan.indices)), self.dtype)
        given: list[np.ndarray] = [np.ascontiguousarray(each, self.dtype) for each in (q, v, acc)]
        self.run(
            evaluate_states, self.evaluator, self.plan, self.functions, *curves, np.asarray(levels, float), joints_only,
            *given, allocate_terms(self.plan, self.dtype), self.work, residuals, values,
        )  # fmt: skip
        none = np.zeros((self.n, 0))
        return [Terms._make((*residuals[k], *values[k], none, none)) for k in range(count)]

    def evaluate_touched(self, inputs: Inputs, q: np.ndarray, v: np.ndarray, acc: np.ndarray) -> tuple[Terms, np.ndarray]:
        """Residual and derivatives by the state, and those of `applied` by the design at the entries that the plan names."""
        if not self.compiled:
            terms = self.evaluate(inputs, q, v, acc, design=True)
            return terms, terms.A_x[self.plan.touched_row, self.plan.touched_variable]
        memory = self._evaluate(inputs, q, v, acc, True, self.n_x > 0, False)
        return memory.found(True, False), memory.applied_touched()

    def _evaluate(
        self, inputs: Inputs, q: np.ndarray, v: np.ndarray, acc: np.ndarray, linearize: bool, design: bool, apart: bool
    ) -> EvaluationMemory:
        """Residual and derivatives as `evaluate`, compiled, into the memory of this thread."""
        curves, curves_x, scale, levels, inertia, joints_only = inputs
        inputs = Inputs(
            np.ascontiguousarray(curves, float),
            np.ascontiguousarray(curves_x, float),
            float(scale),
            np.ascontiguousarray(levels, float),
            bool(inertia),
            bool(joints_only),
        )
        memory, plan, functions = self._memory, self._handed.of(self.plan), self._handed.of(self.functions)
        given = plan, functions, inputs, *memory.state(q, v, acc), bool(linearize), design, memory.terms, memory.work
        if memory.formula is None:
            memory.formula = entry_point(evaluate_all, *given)
        memory.care[1] = apart
        memory.formula(*given)
        return memory

    @cached_property
    def _memory(self) -> EvaluationMemory:
        if self.origin is not None and self._handed.shares_spare(self.origin._handed):
            return self.origin._memory
        return EvaluationMemory(self.plan)

    @cached_property
    def evaluator(self) -> Callable | Formula:
        """`evaluate_all` as an argument of the step loop; it exists compiled once any state has been evaluated."""
        if not self.compiled:
            return plain(evaluate_all)
        if self.origin is not None:  # to look at the types of the arrays takes longer than a short run
            return self.origin.evaluator
        (q, v, *_), inputs = self.start(), self.inputs(0.0, np.zeros(3))
        terms, work = allocate_terms(self.plan, self.dtype), allocate_work(self.plan, self.dtype)
        given = self.plan, self.functions, inputs, q, v, np.zeros(self.n), True, False, terms, work
        return formula_for(evaluate_all, *given)

    @cached_property
    def backward(self) -> GatheredDesign:
        """Plan of a backward run, and what that gathers for all variables together."""
        found = gathered_design(self.plan)
        self._handed.take(found.plan)
        return found

    @cached_property
    def driven(self) -> Plan:
        """The plan with drivers for its joints, where these do work alone; in space all joints, if there are any drivers."""
        joints, drives = self.plan.joints, self.plan.joints.curve >= 0
        kept = drives if joints.felt_start is None or not drives.any() else np.ones(len(drives), bool)
        found: Plan = self.plan._replace(joints=joints._replace(of=joints.of[kept]))
        self._handed.take(found)
        return found

    def refuse_changed_files(self) -> None:
        """Refuse to go on where the file of a reduced model is not what it was when the scene was compiled."""
        refuse_changed(self.files)

    def _touches_as(self, other: System) -> bool:
        """Whether the design variables act on the same equations as those of another one."""
        pairs = ((getattr(each.plan, name) for each in (self, other)) for name in ("touched_row", "touched_variable"))
        return all(mine is its or np.array_equal(mine, its) for mine, its in pairs)

    def scratch(self, key: Hashable, make: Callable[[], R]) -> R:
        """Record of scratch memory, whatever it holds: one that a run has given back under the key, or else a new one."""
        return self._handed.scratch(key, make) if self._keeps_memory else make()

    def give_back(self, key: Hashable, record: object) -> None:
        """Leave a record of `scratch` to the next run of this system, or of one that is compiled as it is."""
        if self._keeps_memory:
            self._handed.give_back(key, record)

    @cached_property
    def _keeps_memory(self) -> bool:
        """Whether runs are so short that new memory takes long beside them; not where numba is switched off."""
        return self._is_short(self._handed)

    def _is_short(self, handed: HandedRecords) -> bool:
        return self.compiled and self.n <= KEPT_MEMORY_UNKNOWNS and isinstance(handed.of(self.plan), Packed)

    def times(self, values: np.ndarray, block: np.ndarray, first: int = 0) -> np.ndarray:
        """Rows from the `first` on of the product of a matrix, by its values on the common pattern, with a block (n, k)."""
        begins = self.plan.indptr[first]
        if (len(values) - begins) * block.shape[1] > LOOPED_PRODUCT_TERMS:
            large: np.ndarray = self.matrix(values)[first:] @ block
            return large
        terms = values[begins:, None] * block[self.plan.indices[begins:]]
        found: np.ndarray = np.add.reduceat(terms, self.plan.indptr[first:-1] - begins, axis=0)
        return found

    def matrix(self, values: np.ndarray) -> scipy.sparse.csr_array:
        """Values on the common pattern as a sparse matrix (n, n)."""
        return scipy.sparse.csr_array((values, self.plan.indices, self.plan.indptr), shape=(self.n, self.n))

    def diagonal(self, values: np.ndarray) -> np.ndarray:
        """Diagonal (n,) of a matrix, by its values on the common pattern."""
        found, (row, column) = np.zeros(self.n, values.dtype), np.divmod(self._places, self.n)
        found[row[row == column]] = values[row == column]
        return found

    def dense(self, values: np.ndarray) -> np.ndarray:
        """Values on the common pattern as an array (n, n)."""
        found: np.ndarray = np.zeros(self.n * self.n, values.dtype)
        found[self._places] = values
        return found.reshape(self.n, self.n)

    @cached_property
    def _places(self) -> np.ndarray:
        """Places of the entries of the common pattern in an array (n n,)."""
        found: np.ndarray = np.repeat(np.arange(self.n), np.diff(self.plan.indptr)) * self.n + self.plan.indices
        return found

    def most_moved(self, change: np.ndarray) -> str:
        """Name of the coordinate that a change of [q; ...] moves most, in parts of the model size (or rad).

        Of equal ones it is the first.
        """
        return self.numbering.names[first_largest(self.weights[: self.n_q] * np.abs(np.real(change[: self.n_q])))]

    def undeformed(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates where every body is in its place and none is deformed, padded to n, and their design derivatives (n, n_x)."""
        q, dq = self._undeformed
        return q.copy(), dq

    def start(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Given coordinates and velocities, both padded to n, and their design derivatives (n, n_x), which nobody can write to."""
        q, v, dq, dv = self._start
        return q.copy(), v.copy(), dq, dv

    @cached_property
    def _undeformed(self) -> tuple[np.ndarray, np.ndarray]:
        q, _, dq, _ = self.start()
        dq = dq.copy() if np.any(dq) else dq
        for b, (name, body) in enumerate(self.scene.all_bodies().items()):
            first = self.numbering.first[name]
            elastic = slice(first + body.frame_size, first + len(self.values.start[b][0]))
            q[elastic] = 0
            if dq.flags.writeable:
                dq[elastic] = 0
        dq.flags.writeable = False
        return q, dq

    @cached_property
    def _start(self) -> tuple[np.ndarray, ...]:
        first = list(self.numbering.first.values())
        states: np.ndarray = np.zeros((2, self.n), self.dtype)
        changes = np.zeros((2, self.n, self.n_x))
        for b, of_body in self.values.start.items():
            states[:, first[b] : first[b] + len(of_body[0])] = of_body
        for x, derivative in enumerate(self.derivatives):
            for b, of_body in derivative.start.items():
                changes[:, first[b] : first[b] + len(of_body[0]), x] = of_body
        changes.flags.writeable = False
        return states[0], states[1], changes[0], changes[1]

    def curves(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """f, f', f'' of all time curves (n_t, n_curves, 3) and of their active design derivatives (n_t, n_d, 3)."""
        return self.curve_values(times), remembered(self._known_changes, times, self._curve_changes)

    def curve_values(self, times: np.ndarray) -> np.ndarray:
        """f, f', f'' of all time curves (n_t, n_curves, 3).

        Those of the last times are remembered, because the parts of an analysis ask for the same ones.
        """
        return remembered(self.known_curves, times, self._curve_values)

    def _curve_values(self, times: np.ndarray) -> np.ndarray:
        found: np.ndarray = np.zeros((len(times), len(self.values.curves), 3), self.dtype)
        for c, curve in enumerate(self.values.curves.values()):
            found[:, c] = curve.evaluate(times)
        return found

    def _curve_changes(self, times: np.ndarray) -> np.ndarray:
        pairs = list(zip(self.plan.curve_index, self.plan.curve_variable, strict=True))
        found = np.zeros((len(times), len(pairs), 3))
        for d, (c, x) in enumerate(pairs):
            found[:, d] = np.imag(self.derivatives[x].curves[c].evaluate(times)) / STEP
        return found

    @cached_property
    def _known_changes(self) -> Known:
        return {}

    @property
    def work(self) -> ScratchMemory:
        """Scratch memory of this thread for kernels that evaluate one state."""
        return self._memory.work if self.compiled else allocate_work(self.plan, self.dtype)

    def inputs(self, time: float, levels: np.ndarray, scale: float = 1.0) -> Inputs:
        """Inputs of the equations at one time."""
        curves, curves_x = self.curves(np.array([time]))
        return Inputs(curves[0], curves_x[0], scale, np.asarray(levels, float), True, False)


@lru_cache(maxsize=8)
def _analysed(indptr: bytes, indices: bytes, n_q: int, moving: bytes) -> LUPlan:
    """Analysis of a pattern, once for scenes that have the same: those of other numbers, and of a complex step."""
    return analyse(np.frombuffer(indptr, np.int64), np.frombuffer(indices, np.int64), n_q, np.frombuffer(moving, bool))


def compile_scene(scene: Scene, design: list[str] | None = None, markers: tuple[tuple[str, str], ...] = ()) -> System:
    """Compile a scene with the named design variables (none by default) and, on request, markers that no component needs.

    Raises
    ------
    InputError
        A name, a path, a body's grip or a parameter is wrong; or a driver is redundant.
    """
    files = file_states(scene)
    scene = resolve(scene)
    check_numbers(scene)
    variables = scene.design_variables(design or [])
    numbering = number(scene, markers)
    values, seen = seen_quantities(scene, numbering)
    changes = derivatives(scene, numbering, variables, seen)
    on_common_pattern(values, changes)
    dtype = complex if holds_complex(scene) else float
    sizes = weights(scene, numbering)
    plan = build_plan(scene, numbering, values, changes, dtype, sizes)
    functions = formulas_of(scene) if dtype is float else plain_formulas_of(scene)
    moving = moving_unknowns(numbering, values, plan.markers.coordinate)
    if numbering.n <= KEPT_MEMORY_UNKNOWNS:
        lu_plan = _analysed(plan.indptr.tobytes(), plan.indices.tobytes(), plan.n_q, moving.tobytes())
    else:
        lu_plan = analyse(plan.indptr, plan.indices, plan.n_q, moving)
    asked = seen.asked_by_components
    system = System(scene, variables, numbering, plan, lu_plan, values, changes, functions, dtype, sizes, files, asked)
    return without_redundant_rows(system) if scene.solver.redundant == "least-squares" else system
