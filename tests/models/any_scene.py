"""What holds for the equations of every scene; a test module in the plane or in space takes it beside its own fixture `scene`."""

from __future__ import annotations

import numpy as np

from toolkit.api.comparison import (
    STEP,
    TOLERANCE,
    check_design_derivatives,
    check_state_derivatives,
    inputs,
    plain_terms,
    random_state,
)
from toolkit.system.system import compile_scene


def close(ours: np.ndarray, reference: np.ndarray, tolerance: float = TOLERANCE) -> None:
    np.testing.assert_allclose(ours, reference, rtol=0, atol=tolerance * np.abs(reference).max(initial=1e-300))


def test_state_derivatives_are_the_complex_step_of_the_residual(scene):
    check_state_derivatives(scene)


def test_design_derivatives_are_the_complex_step_of_the_residual(scene):
    check_design_derivatives(scene)


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
