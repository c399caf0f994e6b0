"""What holds for the equations of every scene; a test module in the plane or in space takes it beside its own fixture `scene`."""

from __future__ import annotations

import numpy as np

from tests.models.directions import combined, direction
from toolkit.conformance.comparison import STEP, TOLERANCE
from toolkit.conformance.residual import design_paths, inputs, plain_terms, random_state
from toolkit.system.system import compile_scene


def close(ours: np.ndarray, reference: np.ndarray, tolerance: float = TOLERANCE) -> None:
    np.testing.assert_allclose(ours, reference, rtol=0, atol=tolerance * np.abs(reference).max(initial=1e-300))


def test_state_derivatives_are_the_complex_step_of_the_residual(scene):
    """Along one direction of all accelerations and multipliers, of all q, and of all v: a wrong entry shows in its row."""
    system = compile_scene(scene)
    state, n_q = random_state(system), system.n_q
    terms = system.evaluate(inputs(system), *state)
    I_acc, I_q, A_q, A_v = (system.matrix(values).toarray() for values in (terms.I_acc, terms.I_q, terms.A_q, terms.A_v))
    zero = np.zeros_like(I_acc)
    for which, count, inertial, applied in ((2, system.n, I_acc, zero), (0, n_q, I_q, A_q), (1, n_q, zero, A_v)):
        factors = np.zeros(system.n)
        factors[:count] = list(direction(map(str, range(count))).values())
        moved = [item + 1j * STEP * factors if k == which else item for k, item in enumerate(state)]
        judge = plain_terms(system, inputs(system), *moved)
        for ours, exact in ((inertial, judge.inertial), (applied, judge.applied)):
            largest = np.abs(ours).max(initial=1e-300)
            np.testing.assert_allclose(ours @ factors, exact.imag / STEP, rtol=0, atol=TOLERANCE * largest)
            assert not ours[:, count:].any()  # multipliers are no coordinates: nothing depends on their q and v


def test_design_derivatives_are_the_complex_step_of_the_residual(scene):
    """Along two directions of all numbers, in which each moves its largest inertial or its largest applied entry by about one.

    Entries that cancel to zero leave round-off, so that a number without effect moves by its own size alone.
    """
    paths = design_paths(scene)
    system = compile_scene(scene, paths)
    state = random_state(system)
    terms = system.evaluate(inputs(system), *state, design=True)
    residual = max(np.abs(terms.inertial).max(initial=0), np.abs(terms.applied).max(initial=0))
    whole = np.array([residual / max(abs(scene.number(path)), 1.0) for path in paths])
    for group, ours in (("inertial", terms.I_x), ("applied", terms.A_x)):
        largest = np.abs(ours).max(axis=0, initial=0)
        factors = list(direction(paths).values()) / np.where(largest > 1e-4 * whole, largest, whole)
        other = compile_scene(scene.moved(combined(scene, dict(zip(paths, factors, strict=True))), 1j * STEP))
        exact = getattr(plain_terms(other, inputs(other), *state), group).imag / STEP
        size = np.abs(exact).max(initial=1.0)
        np.testing.assert_allclose(ours @ factors, exact, rtol=0, atol=TOLERANCE * size, err_msg=group)


def test_compiled_formulas_equal_the_plain_ones(scene):
    system = compile_scene(scene)
    state = random_state(system)
    compiled, reference = system.evaluate(inputs(system), *state), plain_terms(system, inputs(system), *state, linearize=True)
    for name in ("inertial", "applied", "I_acc", "I_q", "A_q", "A_v"):
        # the compiler may contract a product and a sum into one operation: a few units in the last place of sums of some ten terms
        close(getattr(compiled, name), getattr(reference, name), tolerance=1e-14)


def test_constraint_levels_are_time_derivatives_of_one_another(scene):
    """Velocity level = d/dt position level, acceleration level = d/dt velocity level, along any motion; lengths of quaternions too."""
    system = compile_scene(scene)
    q, v, acc = random_state(system)
    n_q, a = system.n_q, np.where(np.arange(system.n) < system.n_q, acc, 0)

    def rows(level: int, later: complex = 0) -> np.ndarray:
        given = inputs(system, np.eye(3)[2 - level])
        f, f_1, f_2 = given.curves.T
        curves = np.stack([f + later * f_1, f_1 + later * f_2, f_2 + 0 * later], axis=1)
        terms = plain_terms(system, given._replace(curves=curves), q + later * v, v + later * a, acc)
        return (terms.inertial + terms.applied)[n_q:]

    for level in (0, 1):
        close(rows(level + 1), rows(level, 1j * STEP).imag / STEP)


def test_constraint_forces_do_no_work_in_allowed_motions(scene):
    """The forces are phi_q^T lam with the phi_q of the position level."""
    system = compile_scene(scene)
    (q, v, acc), n_q = random_state(system), system.n_q
    phi_q = system.matrix(system.evaluate(inputs(system, np.array([0, 0, 1.0])), q, v, acc).A_q).toarray()[n_q:, :n_q]
    free = np.where(np.arange(system.n) < n_q, acc, 0)
    force = (system.evaluate(inputs(system), q, v, acc).inertial - system.evaluate(inputs(system), q, v, free).inertial)[:n_q]
    close(force, phi_q.T @ acc[n_q:], tolerance=1e-12)  # round-off of the subtraction
