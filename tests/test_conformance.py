"""Every component against the complex step of its own residual, in states that are neither small nor consistent."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.cases import CASES, SINE, Case, write_models
from toolkit.bodies.rigid import Rigid
from toolkit.compilation.component_arrays import families
from toolkit.compilation.quantities import loads_of
from toolkit.equations import Inputs, Terms, allocate_terms, allocate_work, evaluate
from toolkit.joints.driver import PositionDriver
from toolkit.joints.joint import Joint, PointJoint
from toolkit.kernel import kernel, plain
from toolkit.loads.gravity import Gravity
from toolkit.loads.load import Load
from toolkit.point import Point
from toolkit.run_options import RunOptions
from toolkit.scene import Scene
from toolkit.solvers.transient import simulate
from toolkit.system import System, compile_scene

H = 1e-30
LEVELS = np.array([1.0, 0.7, 0.3])
TOLERANCE = 1e-10
"""Relative to the largest entry: only round-off separates an exact derivative from a complex step."""


@pytest.fixture(scope="session")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("models")
    write_models(path)
    return path


@pytest.fixture(params=CASES, ids=lambda case: case.name)
def scene(request, directory) -> Scene:
    return request.param.scene(directory)


def random_state(system: System, seed: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q near the start, v and [a; lam], all random and of order one."""
    rng = np.random.default_rng(seed)
    q, v, acc = rng.normal(size=(3, system.n))
    q = system.start()[0] + 0.7 * q
    q[system.n_q :] = v[system.n_q :] = 0
    return q, v, acc


def inputs(system: System, levels: np.ndarray = LEVELS) -> Inputs:
    return system.inputs(0.37, levels, 0.8)


def plain_terms(system: System, given: Inputs, q: Any, v: Any, acc: Any, linearize: bool = False) -> Terms:
    """Evaluate as plain Python, with complex arrays if the state is complex."""
    scene, dtype = system.scene, np.result_type(q, v, acc, system.dtype)
    components: tuple[list, list] = list(scene.joints.values()), loads_of(scene)
    functions = tuple(tuple(plain(formula) for formula in families(group)) for group in components)
    terms, work = allocate_terms(system.plan, dtype), allocate_work(system.plan, dtype)
    arrays = [np.asarray(item, dtype) for item in (q, v, acc)]
    plain(evaluate)(system.plan, functions, given, *arrays, linearize, terms, work)
    return terms


def stepped(state: tuple, which: int, direction: np.ndarray) -> list[np.ndarray]:
    """The state with a complex step of one of q, v, acc."""
    return [item + 1j * H * direction if k == which else item for k, item in enumerate(state)]


def complex_step(system: System, state: tuple, which: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives (n, count) of both groups of the residual."""
    columns = []
    for direction in np.eye(system.n)[:count]:
        terms = plain_terms(system, inputs(system), *stepped(state, which, direction))
        columns.append((terms.inertial.imag / H, terms.applied.imag / H))
    return np.stack([c[0] for c in columns], axis=1), np.stack([c[1] for c in columns], axis=1)


def close(ours: np.ndarray, reference: np.ndarray, tolerance: float = TOLERANCE) -> None:
    np.testing.assert_allclose(ours, reference, rtol=0, atol=tolerance * np.abs(reference).max(initial=1e-300))


def check_state_derivatives(scene: Scene) -> None:
    system = compile_scene(scene)
    state, n_q = random_state(system), system.n_q
    terms = system.evaluate(inputs(system), *state)
    I_acc, I_q, A_q, A_v = (system.matrix(values).toarray() for values in (terms.I_acc, terms.I_q, terms.A_q, terms.A_v))
    for which, count, inertial, applied in ((2, system.n, I_acc, None), (0, n_q, I_q, A_q), (1, n_q, None, A_v)):
        reference = complex_step(system, state, which, count)
        for ours, exact in zip((inertial, applied), reference, strict=True):
            if ours is None:
                assert not np.any(exact)
            else:
                close(ours[:, :count], exact)
                assert not np.any(ours[:, count:])


def check_design_derivatives(scene: Scene) -> None:
    paths = design_paths(scene)
    system = compile_scene(scene, paths)
    state = random_state(system)
    terms = system.evaluate(inputs(system), *state, design=True)
    for x, path in enumerate(paths):
        other = compile_scene(scene.with_number(path, scene.number(path) + 1j * H))
        reference = plain_terms(other, other.inputs(0.37, LEVELS, 0.8), *state)
        for ours, exact in ((terms.I_x[:, x], reference.inertial), (terms.A_x[:, x], reference.applied)):
            size = max(np.abs(exact.imag / H).max(), 1e-3)  # entries are of order one, unless they cancel to zero
            np.testing.assert_allclose(ours, exact.imag / H, rtol=0, atol=TOLERANCE * size, err_msg=path)


def design_paths(scene: Scene) -> list[str]:
    """Paths of all numbers of a scene that can be design variables: not the times of a table, not the place of a node."""
    return [path for path in scene.available_paths() if ".times." not in path and path != "points.U.arc_length"]


def test_state_derivatives_are_the_complex_step_of_the_residual(scene):
    check_state_derivatives(scene)


def test_design_derivatives_are_the_complex_step_of_the_residual(scene):
    check_design_derivatives(scene)


def test_compiled_formulas_equal_the_plain_ones(scene):
    system = compile_scene(scene)
    state = random_state(system)
    compiled, reference = system.evaluate(inputs(system), *state), plain_terms(system, inputs(system), *state, linearize=True)
    for name in ("inertial", "applied", "I_acc", "I_q", "A_q", "A_v"):
        # the compiler may contract a product and a sum into one operation: a few units in the last place
        close(getattr(compiled, name), getattr(reference, name), tolerance=1e-14)


def test_constraint_levels_are_time_derivatives_of_one_another(scene):
    """Velocity level = d/dt position level, acceleration level = d/dt velocity level, along any motion."""
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
        close(rows(level + 1), rows(level, 1j * H).imag / H)


def test_constraint_forces_do_no_work_in_allowed_motions(scene):
    """The forces are phi_q^T lam with the phi_q of the position level."""
    system = compile_scene(scene)
    (q, v, acc), n_q = random_state(system), system.n_q
    phi_q = system.matrix(system.evaluate(inputs(system, np.array([0, 0, 1.0])), q, v, acc).A_q).toarray()[n_q:, :n_q]
    free = np.where(np.arange(system.n) < n_q, acc, 0)
    force = (system.evaluate(inputs(system), q, v, acc).inertial - system.evaluate(inputs(system), q, v, free).inertial)[:n_q]
    close(force, phi_q.T @ acc[n_q:], tolerance=1e-12)  # round-off of the subtraction


@pytest.mark.parametrize("case", [case for case in CASES if case.kind is None], ids=lambda case: case.name)
def test_inertia_forces_are_those_of_lagrange(case, directory):
    """M a - F_v = d/dt (M v) - d/dq (v^T M v / 2), with M(q) from the coefficients of the accelerations."""
    system = compile_scene(case.scene(directory))
    (q, v, acc), n_q = random_state(system), system.n_q

    def mass(position: np.ndarray) -> np.ndarray:
        return system.matrix(plain_terms(system, inputs(system), position, 0 * v, 0 * acc, linearize=True).I_acc).toarray()

    rate = np.stack([mass(q + 1j * H * e).imag / H for e in np.eye(system.n)[:n_q]])  # (k, i, j): dM_ij / dq_k
    M, damping = mass(q), system.matrix(system.evaluate(inputs(system), q, 0 * v, acc).A_v) @ v
    lagrange = M @ acc + np.einsum("kij,k,j->i", rate, v, v) - np.einsum("kij,i,j->k", rate, v, v) / 2
    moving, resting = (system.evaluate(inputs(system), q, rates, acc) for rates in (v, 0 * v))
    close(moving.inertial + moving.applied - resting.applied - damping, lagrange, tolerance=1e-12)
    np.testing.assert_allclose(M, M.T, rtol=0, atol=1e-14)


@kernel
def parabola(z, w, phi, phi_z, phi_zz, phi_zww):
    """phi = d_y - p d_x^2, d = r_a - r_b."""
    d_x, rate = z[0] - z[3], w[0] - w[3]
    phi[0] = z[1] - z[4] - z[6] * d_x * d_x
    phi_z[0, 1], phi_z[0, 4], phi_z[0, 6] = 1, -1, -d_x * d_x
    for a in range(2):
        sign_a = 1 - 2 * a
        phi_z[0, 3 * a] = -2 * z[6] * d_x * sign_a
        phi_zz[0, 3 * a, 6] = phi_zz[0, 6, 3 * a] = -2 * d_x * sign_a
        for b in range(2):
            phi_zz[0, 3 * a, 3 * b] = -2 * z[6] * sign_a * (1 - 2 * b)
    phi_zww[0, 6] = -2 * rate * rate


class ParabolaGuide(PointJoint):
    """A user's own joint: the point of body a moves on a parabola fixed in space with its vertex at the point of body b."""

    kind = "test-parabola-guide"
    formula = parabola

    steepness: float

    @property
    def row_names(self) -> list[str]:
        """One direction."""
        return ["height"]

    def parameters(self, _scene) -> list[Any]:
        """p."""
        return [self.steepness]


@pytest.mark.parametrize(("bodies", "point"), [(("strip", "rod"), "T"), (("rod", "ground"), "A")])
def test_a_users_own_joint_plugs_in(bodies, point, directory):
    scene = Case("parabola", ParabolaGuide, {"steepness": 0.6}, bodies, (point, point), point).scene(directory)
    check_state_derivatives(scene)
    check_design_derivatives(scene)


def test_a_bead_on_a_users_parabola_keeps_its_energy():
    scene = Scene(
        units="m-kg-s",
        points={"P": Point(x=0.0, y=0.0)},
        bodies={"bead": Rigid(mass=2.0, inertia=1.0, center="P", velocity=(3.0, 0.0, 0.0))},
        joints={"wire": ParabolaGuide(bodies=("bead", "ground"), point="P", steepness=0.6)},
        loads={"gravity": Gravity(acceleration=(0.0, -9.81))},
    )
    run = simulate(compile_scene(scene), RunOptions(end_time=2.0, step=1e-3, rho_inf=1.0))
    energy = (run.v[:, :2] ** 2).sum(axis=1) / 2 + 9.81 * run.q[:, 1]
    assert np.abs(energy / energy[0] - 1).max() < 1e-4  # second order: (step / shortest time scale)^2 = (1e-3 / 0.1)^2
    np.testing.assert_allclose(run.q[:, 1], 0.6 * run.q[:, 0] ** 2, atol=1e-5)


@pytest.mark.parametrize("base", [Joint, PointJoint, Load])
def test_a_component_without_formula_cannot_be_created(base):
    with pytest.raises(TypeError, match=r"Forgetful has no `formula`.*must not pass for zero"):
        type("Forgetful", (base,), {"kind": "test-forgetful", "__module__": __name__})


def test_a_refused_component_cannot_be_named_in_a_scene_file():
    with pytest.raises(TypeError, match="no `formula`"):
        type("Refused", (Joint,), {"kind": "test-refused", "__module__": __name__})
    assert "test-refused" not in Joint.kinds


def test_two_components_of_one_kind_share_one_family(directory):
    case = next(case for case in CASES if case.kind is PositionDriver)
    scene = case.scene(directory)
    twice = scene.model_copy(
        update={"joints": {**scene.joints, "again": scene.joints["component"].model_copy(update={"curve": SINE})}}
    )
    assert len(families(list(twice.joints.values()))) == 1
    check_state_derivatives(twice)
