"""Frames of fewer coordinates move as the full one under constraints; a cantilever in space against closed forms; a shaft that spins."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eig

from tests.spatial.scenes import at, save_frame
from toolkit.analyses.modes import solve_modes, undeformed
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.bodies.rigid import SpatialRigid
from toolkit.components.curves.polynomial import Constant
from toolkit.components.joints.driver import SpatialAngleDriver
from toolkit.components.joints.joint import SpatialPointJoint
from toolkit.components.joints.revolute import SpatialRevolute
from toolkit.components.joints.rigid_joint import SpatialRigidJoint
from toolkit.components.joints.rows import Row
from toolkit.components.loads.gravity import SpatialGravity
from toolkit.components.loads.point_force import SpatialPointForce
from toolkit.components.loads.springs import SpatialSpringDamper
from toolkit.components.loads.torque import SpatialTorque
from toolkit.components.markers.component import Skeleton
from toolkit.description.design import BodyPoint
from toolkit.description.run_options import RunOptions
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of
from toolkit.scene.scene import Scene
from toolkit.system.system import System, compile_scene

Z = (0.0, 0.0, 1.0)
AXIS = (0.3, -0.2, 1.0)
E, NU, RHO, DIAMETER, LENGTH = 7e10, 0.3, 2700.0, 4e-3, 1.0
AREA, SECOND = np.pi * DIAMETER**2 / 4, np.pi * DIAMETER**4 / 64
SHEAR = E / (2 * (1 + NU))
BEAM = """units = "m-kg-s"
clamp = ["root"]
nodes = {{ root = [0, 0, 0], tip = {tip} }}
beams = [{{ from = "root", to = "tip", section = "round", elements = {elements} }}]
sections = {{ round = {{ kind = "circle", diameter = 4e-3, material = "alloy" }} }}
materials = {{ alloy = {{ youngs_modulus = {modulus}, poisson_ratio = 0.3, density = 2700.0 }} }}
interface_points = {{ root = {{ node = "root" }}, tip = {{ node = "tip" }} }}
{basis}
"""
ENDS = {name: BodyPoint(body="beam", interface=name) for name in ("root", "tip")}


class Upright(SpatialPointJoint):
    """No relative rotation, every displacement free."""

    def constraint(self, _scene: Skeleton | None) -> tuple[Row, ...]:
        return self.poses.locked


def beam(folder, elements=4, tip=(0.0, 0.0, LENGTH), modulus=E, basis=""):
    save_frame(folder, "beam", BEAM.format(elements=elements, tip=list(tip), modulus=modulus, basis=basis))
    return folder


def extrapolated(levels: list[np.ndarray]) -> np.ndarray:
    """Errors in h^2, h^3, h^4, ... taken out of results at h, h / 2, h / 4, ..."""
    for order in range(2, len(levels) + 1):
        levels = [fine + (fine - coarse) / (2**order - 1) for coarse, fine in pairwise(levels)]
    return levels[0]


def limit(scene: Scene, end: float, step: float, body: str, columns: slice) -> np.ndarray:
    """Some of a body's coordinates at the end, extrapolated to a step of zero."""
    system, levels = compile_scene(scene), []
    for k in range(5):
        run = simulate(system, RunOptions(end_time=end, step=step / 2**k, rho_inf=0.8, tolerance=1e-13))
        levels.append(run.q[-1, run.coordinates(body)][columns])
    return extrapolated(levels)


def quaternion_about(axis, angle: float) -> np.ndarray:
    n = np.array(axis) / np.linalg.norm(axis)
    return np.append(np.cos(angle / 2), np.sin(angle / 2) * n)


def test_a_pendulum_on_a_turning_frame_moves_as_one_on_a_hinge():
    body = {"mass": 2.0, "inertia": (0.3, 0.2, 0.25, 0.02, -0.01, 0.03), "center": "C"}
    parts = {
        "units": "m-kg-s",
        "dimension": 3,
        "points": at(O=(0.1, 0.2, 0.3), C=(0.9, 0.0, 0.1), S=(1.5, 1.0, 1.0)),
        "loads": {
            "weight": SpatialGravity(acceleration=(0.0, -9.81, -1.0)),
            "spring": SpatialSpringDamper(bodies=("arm", "ground"), points=("C", "S"), stiffness=20.0, damping=1.0),
        },
    }
    hinge = {"O": SpatialRevolute(bodies=("arm", "ground"), point="O", axis=AXIS)}
    omega = tuple(float(x) for x in 2 * np.array(AXIS))
    free = Scene(**parts, bodies={"arm": SpatialRigid(**body, origin="O", angular_velocity=omega)}, joints=hinge)
    fixed = Scene(**parts, bodies={"arm": SpatialRigid(**body, origin="O", frame="turning", axis=AXIS, angular_velocity=omega)})
    turned = limit(fixed, 1.0, 0.02, "arm", slice(0, 1))
    full = limit(free, 1.0, 0.02, "arm", slice(0, 7))
    np.testing.assert_allclose(full[:3], [0.1, 0.2, 0.3], rtol=0, atol=1e-10)  # what five steps leave: h^6
    np.testing.assert_allclose(full[3:], quaternion_about(AXIS, turned[0]), rtol=0, atol=1e-10)


def test_a_flexible_pendulum_on_a_turning_frame_moves_as_one_on_a_hinge(tmp_path):
    beam(tmp_path, tip=(0.8, 0.1, 0.2), modulus=7e9, basis='basis = { kind = "eigenmodes", count = 2 }')
    parts = {
        "units": "m-kg-s",
        "dimension": 3,
        "directory": tmp_path,
        "points": ENDS,
        "loads": {"weight": SpatialGravity(acceleration=(0.0, -9.81, -1.0))},
    }
    omega, place = tuple(float(x) for x in 2 * np.array(AXIS)), {"model": "beam.h5", "orientation": (0.2, 0.1, -0.3)}
    hinge = {"O": SpatialRevolute(bodies=("beam", "ground"), point="root", axis=AXIS)}
    free = Scene(**parts, bodies={"beam": SpatialFlexible(**place, frame="moving", angular_velocity=omega)}, joints=hinge)
    fixed = Scene(**parts, bodies={"beam": SpatialFlexible(**place, frame="turning", axis=AXIS, angular_velocity=omega)})
    turned, full = limit(fixed, 0.2, 0.005, "beam", slice(0, 3)), limit(free, 0.2, 0.005, "beam", slice(3, 9))
    start = quaternion_of(np.array(place["orientation"]))
    n = np.array(AXIS) / np.linalg.norm(AXIS)
    expected = matrix_of(quaternion_of(turned[0] * n)) @ matrix_of(start)
    # the first vibration has sixty steps in a period at the coarsest step: its h^6 is left
    np.testing.assert_allclose(matrix_of(full[:4]), expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(full[4:], turned[1:], rtol=0, atol=1e-8 * np.abs(turned[1:]).max())


def test_a_translating_frame_moves_as_a_full_one_that_cannot_turn(tmp_path):
    beam(tmp_path, tip=(0.8, 0.1, 0.2), basis='basis = { kind = "eigenmodes", count = 4 }')
    parts = {
        "units": "m-kg-s",
        "dimension": 3,
        "directory": tmp_path,
        "points": {**ENDS, **at(S=(1.0, 1.0, 0.5))},
        "loads": {
            "weight": SpatialGravity(acceleration=(0.0, -9.81, -1.0)),
            "pull": SpatialPointForce(body="beam", point="tip", force=(0.1, 0.05, 0.2), frame="body"),
            "spring": SpatialSpringDamper(bodies=("beam", "ground"), points=("tip", "S"), stiffness=5.0, damping=0.05),
        },
    }
    place = {"model": "beam.h5", "orientation": (0.2, 0.1, -0.3), "velocity": (0.1, 0.2, -0.3)}
    upright = {"upright": Upright(bodies=("beam", "ground"), point=("(origin)", "S"))}
    parts["points"]["(origin)"] = BodyPoint(body="beam", interface="(frame)")
    options = RunOptions(end_time=0.2, step=0.005, rho_inf=0.8, tolerance=1e-13)
    less = simulate(compile_scene(Scene(**parts, bodies={"beam": SpatialFlexible(**place, frame="translating")})), options)
    full = simulate(
        compile_scene(Scene(**parts, bodies={"beam": SpatialFlexible(**place, frame="moving")}, joints=upright)), options
    )
    own = np.r_[0:3, 7:11]
    # the same steps of the same coordinates
    np.testing.assert_allclose(full.q[:, own], less.q, rtol=0, atol=1e-12 * np.abs(less.q).max())
    np.testing.assert_allclose(full.q[:, 3:7] - full.q[0, 3:7], 0, atol=1e-13)


def test_a_cantilever_in_space_has_the_textbook_deflections(tmp_path):
    """Bent in two directions, stretched and twisted at once, placed obliquely."""
    place = {"model": "beam.h5", "position": (0.3, 0.1, -0.2), "orientation": (0.2, -0.4, 0.3), "frame": "grounded"}
    scene = Scene(units="m-kg-s", dimension=3, directory=beam(tmp_path), points=ENDS, bodies={"beam": SpatialFlexible(**place)})
    A = matrix_of(quaternion_of(np.array(place["orientation"])))
    force, torque = 1e-7 * np.array([1.0, 2.0, 4.0]), 1e-7 * np.array([2.0, -3.0, 2.0])
    loads = {
        "force": SpatialPointForce(body="beam", point="tip", force=tuple(map(float, A @ force))),
        "torque": SpatialTorque(body="beam", point="tip", torque=tuple(map(float, A @ torque))),
    }
    tip = solve_statics(compile_scene(scene.model_copy(update={"loads": loads})), RunOptions(load_steps=1)).q[0].reshape(-1, 6)
    found = tip[np.argmax(np.abs(tip[:, 0]))]  # elastic coordinates are in the body's own axes
    cube, square, bend = LENGTH**3 / (3 * E * SECOND), LENGTH**2 / (2 * E * SECOND), LENGTH / (E * SECOND)
    expected = [
        cube * force[0] + square * torque[1],
        cube * force[1] - square * torque[0],
        force[2] * LENGTH / (E * AREA),
        bend * torque[0] - square * force[1],
        bend * torque[1] + square * force[0],
        torque[2] * LENGTH / (SHEAR * 2 * SECOND),
    ]
    # rotations of 1e-7: the curvature of their vector; stretching is 1e5 times stiffer, which costs its digits
    np.testing.assert_allclose(np.delete(found, 2), np.delete(expected, 2), rtol=1e-6)
    np.testing.assert_allclose(found[2], expected[2], rtol=1e-6)


@pytest.mark.parametrize("frame", ["grounded", "moving", "turning"])
def test_frequencies_of_a_cantilever_in_space(tmp_path, frame):
    """Pairs of bending modes, and torsion; with a moving or turning frame that a rigid joint holds."""
    joints = {"wall": SpatialRigidJoint(bodies=("beam", "ground"), point="root")} if frame == "moving" else {}
    if frame == "turning":
        joints = {"wall": SpatialAngleDriver(bodies=("beam", "ground"), point="root", axis=Z, curve=Constant(value=0.0))}
    body = SpatialFlexible(model="beam.h5", frame=frame, axis=Z if frame == "turning" else None)
    scene = Scene(units="m-kg-s", dimension=3, directory=beam(tmp_path, 8), points=ENDS, bodies={"beam": body}, joints=joints)
    found = solve_modes(undeformed(compile_scene(scene))).frequencies
    bending = np.array([1.875104068711961, 4.694091132974174]) ** 2 * np.sqrt(E * SECOND / (RHO * AREA)) / (2 * np.pi)
    # (k h)^4 / 720 of the finite elements on eight of them, 6e-5 of the second mode, less the rotary inertia, 2 (k d / 4)^2
    np.testing.assert_allclose(found[:4], np.repeat(bending, 2), rtol=1e-4)
    # (pi / 2)^2 / 24 / 8^2 of linear torsion
    assert np.abs(found / (np.sqrt(SHEAR / RHO) / 4 * (1 + np.pi**2 / 96 / 64)) - 1).min() < 1e-5


def test_a_round_shaft_that_spins_whirls_in_space_as_one_at_rest_vibrates(tmp_path):
    """In the frame that turns with Omega about the shaft, the frequencies are |omega - Omega| and omega + Omega."""
    body = {"model": "beam.h5", "frame": "turning", "axis": Z}
    scene = Scene(units="m-kg-s", dimension=3, directory=beam(tmp_path, 4), bodies={"beam": SpatialFlexible(**body)})
    system, spin = compile_scene(scene), 7.0
    still, whirl = elastic_frequencies(system, 0.0), elastic_frequencies(system, spin)
    expected = np.sort(np.abs([[omega - spin, omega + spin] for omega in still[:4:2]]).ravel())
    # all that tells the spinning shaft from a line is the inertia of its section, (4.7 d / 4)^2
    np.testing.assert_allclose(whirl[:4], expected, rtol=2 * (4.7 * DIAMETER / 4) ** 2)


def elastic_frequencies(system: System, spin: float) -> np.ndarray:
    """Circular frequencies of M c'' + G c' + K c = 0 about steady rotation, without the rotation's own."""
    q, v, acc = np.zeros((3, system.n))
    v[0] = spin
    terms = system.evaluate(system.inputs(0.0, np.zeros(3)), q, v, acc)
    M, G, K = (system.matrix(each).toarray()[1:, 1:] for each in (terms.I_acc, terms.A_v, terms.A_q + terms.I_q))
    one, zero = np.eye(len(M)), np.zeros_like(M)
    roots = eig(np.block([[zero, one], [-K, -G]]), np.block([[one, zero], [zero, M]]), right=False)
    return np.sort(roots.imag[roots.imag > 0])
