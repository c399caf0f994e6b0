"""Two arrays that should be one: the worst entry is named, with both values.

The equations of a whole scene against the complex step of their residual, in states that are neither small nor consistent.

One complex step along a direction of all numbers shows whether any derivative is wrong; only then each is looked at, to name it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolkit.description.design import DesignVariable
from toolkit.foundation.errors import ConformanceError
from toolkit.foundation.kernel import plain
from toolkit.foundation.value_types import Scalar
from toolkit.scene.scene import Scene
from toolkit.system.equations import Inputs, Terms, allocate_terms, allocate_work, evaluate
from toolkit.system.evaluation import plain_formulas_of
from toolkit.system.system import System, compile_scene

STEP = 1e-30
"""Complex step: far below round-off, so that nothing but the first derivative is left."""

TOLERANCE = 1e-10
"""Relative to the largest entry: only round-off separates an exact derivative from a complex step."""


def direction(count: int) -> np.ndarray:
    """A factor for each of some numbers, between 1/2 and 1 and of either sign, so that no two differences cancel by chance."""
    rng = np.random.default_rng(count)
    return rng.uniform(0.5, 1.0, count) * rng.choice([-1.0, 1.0], count)


def agree(ours: np.ndarray | Scalar, exact: np.ndarray | Scalar, size: float) -> bool:
    """Whether derivatives along a direction differ by no more than `TOLERANCE` times a size; what is not finite does not."""
    return bool(np.all(np.abs(ours - exact) <= TOLERANCE * max(size, float(np.abs(exact).max(initial=0)))))


def compare(what: str, ours: np.ndarray, exact: np.ndarray, names: Sequence[Sequence[str]], least: float = 1e-300) -> None:
    """Raise an error if the arrays differ by more than `TOLERANCE` times the largest entry (or `least`).

    Parameters
    ----------
    what : the derivative, for the message
    names : for every axis, what its entries are

    Raises
    ------
    ConformanceError
        Names the entry with the largest difference, both values and the difference relative to the largest entry.
    """
    size = max(float(np.abs(exact).max(initial=0)), least)
    difference = np.where(np.isfinite(ours), np.abs(ours - exact), np.inf)
    if difference.size == 0 or difference.max() <= TOLERANCE * size:
        return
    worst = tuple(int(k) for k in np.unravel_index(int(np.argmax(difference)), difference.shape))
    place = ", ".join(axis[k] for axis, k in zip(names, worst, strict=True))
    share = f"{difference[worst] / size:.2g} of the largest entry" if size > least else "where all should be zero"
    raise ConformanceError(
        f"{what} is wrong at ({place}): it is {ours[worst]:.10g}, a complex step gives {exact[worst]:.10g}; "
        f"the difference is {difference[worst]:.2g}, {share}."
    )


LEVELS = np.array([1.0, 0.7, 0.3])
"""Weights of acceleration, velocity and position of the constraint rows: all three count, none like another."""

CANCELLATION_TOLERANCE = 1e-4
"""Part of the residual below which what a number changes may be round-off of what cancels to zero."""
DESIGN_TERMS = {"inertial": "I_x", "applied": "A_x"}
"""Group of the residual -> its derivatives by the numbers, in `Terms`."""


def check_state_derivatives(scene: Scene, seed: int = 0) -> None:
    """d residual / d (acceleration and multipliers, q, v), compiled, against complex steps of the plain residual."""
    system = compile_scene(scene)
    state, n_q = random_state(system, seed), system.n_q
    terms = system.evaluate(inputs(system), *state)
    names, zero = system.numbering.names, np.zeros((system.n, system.n))
    I_acc, I_q, A_q, A_v = (system.dense(values) for values in (terms.I_acc, terms.I_q, terms.A_q, terms.A_v))
    groups = (("acceleration or multiplier", system.n, I_acc, zero), ("q", n_q, I_q, A_q), ("v", n_q, zero, A_v))
    for (by, count, *ours), which in zip(groups, (2, 0, 1), strict=True):
        factors = np.append(direction(count), np.zeros(system.n - count))
        along = _residual_along(system, state, which, factors)
        known = all(agree(m @ factors, exact, np.abs(m).max(initial=1e-300)) for m, exact in zip(ours, along, strict=True))
        if known and not any(matrix[:, count:].any() for matrix in ours):
            continue
        for group, matrix, exact in zip(("inertial", "applied"), ours, complex_step(system, state, which, count), strict=True):
            beyond = np.zeros((system.n, system.n - count))  # multipliers are no coordinates: nothing depends on their q and v
            compare(f"d {group} / d {by}", matrix, np.hstack([exact, beyond]), [names, names])


def check_design_derivatives(scene: Scene, seed: int = 0) -> None:
    """d residual / d number, for every number of the scene that can be a design variable, against complex steps."""
    paths = design_paths(scene)
    system = compile_scene(scene, paths)
    state = random_state(system, seed)
    terms = system.evaluate(inputs(system), *state, design=True)
    residual = max(np.abs(terms.inertial).max(initial=0), np.abs(terms.applied).max(initial=0))
    whole = np.array([residual / max(abs(scene.number(path)), 1.0) for path in paths])
    if all(_numbers_agree(scene, paths, state, group, getattr(terms, by), whole) for group, by in DESIGN_TERMS.items()):
        return
    for x, path in enumerate(paths):
        other = compile_scene(scene.with_number(path, scene.number(path) + 1j * STEP))
        reference = plain_terms(other, inputs(other), *state)
        least = CANCELLATION_TOLERANCE * whole[x]  # entries that cancel to zero leave round-off
        pairs = (("inertial", terms.I_x, reference.inertial), ("applied", terms.A_x, reference.applied))
        for group, ours, exact in pairs:
            compare(f"d {group} / d {path}", ours[:, x], exact.imag / STEP, [system.numbering.names], least)


def _numbers_agree(scene: Scene, paths: list[str], state: tuple, group: str, ours: np.ndarray, whole: np.ndarray) -> bool:
    """Whether a group of terms changes along a direction in which every number moves its largest entry by about one.

    Entries that cancel to zero leave round-off, so that a number without effect moves by what would change the `whole` residual.
    """
    largest = np.abs(ours).max(axis=0, initial=0)
    sizes = np.where(largest > CANCELLATION_TOLERANCE * whole, largest, whole)
    factors = direction(len(paths)) / np.where(sizes > 0, sizes, 1.0)
    moved = compile_scene(scene.moved(DesignVariable(group, 1.0, tuple(paths), tuple(factors.tolist())), 1j * STEP))
    return agree(ours @ factors, getattr(plain_terms(moved, inputs(moved), *state), group).imag / STEP, 1.0)


def design_paths(scene: Scene) -> list[str]:
    """Paths of all numbers of a scene that can be design variables: not the times of a table."""
    return [path for path in scene.available_paths() if ".times." not in path]


def random_state(system: System, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q near the start, v and [a; lam], all random and of order one."""
    rng = np.random.default_rng(seed)
    q, v, acc = rng.normal(size=(3, system.n))
    q = system.start()[0] + 0.7 * q
    q[system.n_q :] = v[system.n_q :] = 0
    return q, v, acc


def inputs(system: System, levels: np.ndarray = LEVELS) -> Inputs:
    """Inputs of the equations at some time, with the loads scaled."""
    return system.inputs(0.37, levels, 0.8)


def plain_terms(system: System, given: Inputs, q: np.ndarray, v: np.ndarray, acc: np.ndarray, linearize: bool = False) -> Terms:
    """Terms of the equations, evaluated as plain Python, with complex arrays if the state is complex."""
    scene, dtype = system.scene, np.result_type(q, v, acc, system.dtype).type
    functions = plain_formulas_of(scene)
    terms, work = allocate_terms(system.plan, dtype), allocate_work(system.plan, dtype)
    arrays = [np.asarray(item, dtype) for item in (q, v, acc)]
    plain(evaluate)(system.plan, functions, given, *arrays, linearize, terms, work)
    return terms


def complex_step(system: System, state: tuple, which: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives (n, count) of both groups of the residual by q (0), v (1) or [a; lam] (2)."""
    columns = [_residual_along(system, state, which, unit) for unit in np.eye(system.n)[:count]]
    empty = np.zeros((system.n, 0))
    return np.column_stack([empty, *(c[0] for c in columns)]), np.column_stack([empty, *(c[1] for c in columns)])


def _residual_along(system: System, state: tuple, which: int, factors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives (n,) of both groups along a direction (n,) of q (0), v (1) or [a; lam] (2)."""
    moved = [item + 1j * STEP * factors if k == which else item for k, item in enumerate(state)]
    terms = plain_terms(system, inputs(system), *moved)
    return terms.inertial.imag / STEP, terms.applied.imag / STEP
