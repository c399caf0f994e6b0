"""One way to state a joint in the plane and in space: rows of forms, and open formulas of forms, from one class for both."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.cases import Case
from tests.models.cases import write_models as write_planar
from tests.models.spatial_cases import AXIS, SpatialCase
from tests.models.spatial_cases import write_models as write_spatial
from toolkit.analyses.transient import simulate
from toolkit.api.check import check_joint
from toolkit.api.comparison import inputs, random_state
from toolkit.components.bodies.rigid import Rigid, SpatialRigid
from toolkit.components.joints.joint import AtPoint, AxisJoint, Joint, PlanarJoint, PointJoint, SpatialJoint
from toolkit.components.joints.kernels.laws import angle_of
from toolkit.components.joints.revolute import Revolute
from toolkit.components.joints.rows import Row, angle
from toolkit.components.loads.torque import SpatialTorque, Torque
from toolkit.description.design import Point
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ConformanceError, InputError
from toolkit.foundation.kernel import kernel
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("models")
    write_planar(path)
    write_spatial(path)
    return path


@kernel
def wave(h, w, g, g_h, g_hh, g_hww):
    """g = y - p sin(x / p) of h = (x, y, p): no polynomial, and curved in its number."""
    x, p = h[0], h[2]
    u = x / p
    c, s = np.cos(u), np.sin(u)
    g[0] = h[1] - p * s
    g_h[0], g_h[1], g_h[2] = -c, 1, u * c - s
    g_hh[0, 0], g_hh[2, 2] = s / p, u * u * s / p
    g_hh[0, 2] = g_hh[2, 0] = -u * s / p
    v, r = w[0], w[2]
    ppx, ppp = (2 * u * s + u * u * c) / (p * p), -(3 * u * u * s + u * u * u * c) / (p * p)
    xxx, xxp = c / (p * p), -(s + u * c) / (p * p)
    g_hww[0] = xxx * v * v + 2 * xxp * v * r + ppx * r * r
    g_hww[2] = xxp * v * v + 2 * ppx * v * r + ppp * r * r


class OnWave(AtPoint, Joint):
    """The point of body a moves on a wave fixed in space that begins at the point of body b."""

    height: float

    def constraint(self, _scene) -> tuple[Row, ...]:
        """One direction, as an open formula of two components and a number."""
        a, b = self.poses
        d = a.r - b.r
        return (Row("height", "length", (d[0], d[1], self.height), wave),)


class PlanarWave(OnWave, PlanarJoint):
    kind = "test-wave"


class SpatialWave(OnWave, SpatialJoint):
    kind = "test-wave"


def planar(kind, **numbers) -> Case:
    return Case("own", kind, numbers, ("strip", "rod"), ("T", "B"), "T")


def spatial(kind, **numbers) -> SpatialCase:
    return SpatialCase("own", kind, numbers, ("block", "wheel"), ("C", "B"), "B")


@pytest.mark.parametrize("case", [planar(PlanarWave, height=0.6), spatial(SpatialWave, height=0.6)], ids=["plane", "space"])
def test_one_open_formula_serves_the_plane_and_space(case, directory):
    scene = case.scene(directory)
    check_joint(scene.joints["component"], scene)


class Gears(PointJoint):
    """Body a turns -n times as far as body b: a row of forms, with a number."""

    kind = "test-gears"

    ratio: float

    def constraint(self, _scene) -> tuple[Row, ...]:
        """The angles, of any number of turns."""
        a, b = self.poses
        return (Row("rotation", "angle", a.angle + self.ratio * b.angle),)


def test_gears_are_a_row_of_forms(directory):
    scene = planar(Gears, ratio=0.7).scene(directory)
    check_joint(scene.joints["component"], scene)


def test_geared_wheels_turn_as_theory_says_over_many_turns():
    """(J_1 + J_2 / n^2) angle'' = torque."""
    wheels = {"small": Rigid(mass=1.0, inertia=0.02, center="A"), "large": Rigid(mass=9.0, inertia=1.5, center="B")}
    axles = {point: Revolute(bodies=(body, "ground"), point=point) for body, point in (("small", "A"), ("large", "B"))}
    scene = Scene(
        units="m-kg-s",
        points={"A": Point(x=0.0, y=0.0), "B": Point(x=0.4, y=0.0)},
        bodies=wheels,
        joints={**axles, "gears": Gears(bodies=("small", "large"), point=("A", "B"), ratio=3.0)},
        loads={"motor": Torque(body="small", point="A", torque=0.5)},
    )
    run = simulate(compile_scene(scene), RunOptions(end_time=4.0, step=1e-2))
    exact = 0.5 * 0.5 * run.times**2 / (0.02 + 1.5 / 9)
    assert exact[-1] > 2 * 2 * np.pi
    np.testing.assert_allclose(run.q[:, 2], exact, atol=1e-9)  # constant acceleration: exact but for round-off


@kernel
def thread(h, w, g, g_h, g_hh, g_hww):
    """g = x - p angle of h = (x, c, s, p), the angle atan2(s, c) of the turn next to x / p: of any number of turns."""
    x, c, s, p = h[0], h[1], h[2], h[3]
    turn = angle_of(s, c)
    turn += 2 * np.pi * np.round((x / p - turn).real / (2 * np.pi))
    square = c * c + s * s
    t_c, t_s, t_cc, t_cs = -s / square, c / square, 2 * s * c / square**2, (s * s - c * c) / square**2
    t_ccc, t_ccs = 2 * s * (s * s - 3 * c * c) / square**3, 2 * c * (c * c - 3 * s * s) / square**3
    g[0] = x - p * turn
    g_h[0], g_h[1], g_h[2], g_h[3] = 1, -p * t_c, -p * t_s, -turn
    g_hh[1, 1], g_hh[1, 2], g_hh[2, 1], g_hh[2, 2] = -p * t_cc, -p * t_cs, -p * t_cs, p * t_cc
    g_hh[1, 3] = g_hh[3, 1] = -t_c
    g_hh[2, 3] = g_hh[3, 2] = -t_s
    u, v, r = w[1], w[2], w[3]
    along_c, along_s = t_cc * u + t_cs * v, t_cs * u - t_cc * v
    g_hww[1] = -p * (t_ccc * u * u + 2 * t_ccs * u * v - t_ccc * v * v) - 2 * r * along_c
    g_hww[2] = -p * (t_ccs * u * u - 2 * t_ccc * u * v - t_ccs * v * v) - 2 * r * along_s
    g_hww[3] = -(u * along_c + v * along_s)


class Screw(AxisJoint):
    """Body a moves along the axis of body b by `lead` for every radian that it turns about it."""

    kind = "test-screw"

    lead: float

    def constraint(self, _scene) -> tuple[Row, ...]:
        """What a cylindrical joint has, and the thread."""
        (a, b), poses = self.poses, self.poses
        offset = (a.r - b.r) @ b.e(3)
        row = Row("thread", "length", (offset, a.e(1) @ b.e(1), a.e(1) @ b.e(2), self.lead), thread)
        return (*poses.on_line, *poses.aligned, row)


def test_a_screw_is_an_open_formula(directory):
    scene = spatial(Screw, axis=AXIS, lead=0.3).scene(directory)
    check_joint(scene.joints["component"], scene)


def nut(lead: float, **design: str) -> Scene:
    """A nut on a fixed screw along z, turned by a constant torque."""
    return Scene(
        units="m-kg-s",
        dimension=3,
        points={"P": Point(x=0.0, y=0.0, z=0.0)},
        bodies={"nut": SpatialRigid(mass=2.0, inertia=(0.1, 0.1, 0.2), center="P")},
        joints={"screw": Screw(bodies=("nut", "ground"), point="P", axis=(0.0, 0.0, 1.0), lead=lead)},
        loads={"motor": SpatialTorque(body="nut", point="P", torque=(0.0, 0.0, 1.5))},
        design=design,
    )


def test_a_nut_climbs_its_screw_over_several_turns():
    """(J + m p^2) angle'' = torque, z = p angle."""
    run = simulate(compile_scene(nut(0.05)), RunOptions(end_time=2.0, step=2e-3))
    angle = 1.5 * run.times**2 / 2 / (0.2 + 2.0 * 0.05**2)
    assert angle[-1] > 2 * 2 * np.pi
    error = np.abs(run.q[:, 2] - 0.05 * angle).max() / run.q[-1, 2]
    finer = simulate(compile_scene(nut(0.05)), RunOptions(end_time=2.0, step=1e-3))
    half = np.abs(finer.q[::2, 2] - 0.05 * angle).max() / run.q[-1, 2]
    assert error < 1e-3
    assert 3.0 < error / half < 5.0  # second order


def test_a_wrong_open_formula_in_space_is_caught_and_named(directory):
    class Stripped(Screw):
        kind = "test-stripped"

        def constraint(self, scene):
            *others, row = super().constraint(scene)
            return (*others, Row(row.name, row.quantity, row.form, forgetful_thread))

    scene = spatial(Stripped, axis=AXIS, lead=0.3).scene(directory)
    with pytest.raises(ConformanceError, match=r"row 'thread' of 'test-stripped': g_h is wrong at \(thread, h\[3\]\): it is 0"):
        check_joint(scene.joints["component"], scene)


@kernel
def forgetful_thread(h, w, g, g_h, g_hh, g_hww):
    """A thread that forgets its lead."""
    thread(h, w, g, g_h, g_hh, g_hww)
    g_h[3] = 0


def test_a_row_of_two_forms_without_law_is_refused(directory):
    class Lawless(PointJoint):
        kind = "test-lawless-row"

        def constraint(self, _scene):
            a, b = self.poses
            return (Row("both", "length", (a.r[0], b.r[0])),)

    scene = planar(Lawless).scene(directory)
    with pytest.raises(InputError, match="row 'both' of a 'test-lawless-row' joint has 2 forms and no law"):
        check_joint(scene.joints["component"], scene)


class ByAxes(PointJoint):
    """atan2(e_1a . e_2b, e_1a . e_1b), a law of products of axes."""

    kind = "test-by-axes"

    def constraint(self, _scene) -> tuple[Row, ...]:
        a, b = self.poses
        return (angle("rotation", cosine=a.e(1) @ b.e(1), sine=a.e(1) @ b.e(2)),)


class ByAngles(PointJoint):
    """angle_a - angle_b."""

    kind = "test-by-angles"

    def constraint(self, _scene) -> tuple[Row, ...]:
        return (self.poses.turned,)


def test_an_angle_of_axes_is_the_difference_of_angles(directory):
    """Two ways to one row: the chain rule of a law against a linear form."""
    found = []
    for kind in (ByAxes, ByAngles):
        scene = planar(kind).scene(directory)
        check_joint(scene.joints["component"], scene)
        system = compile_scene(scene)
        q, v, acc = random_state(system, seed=3)
        terms = system.evaluate(inputs(system), 0.3 * q, v, acc)
        found.append([terms.inertial, terms.applied, *(system.matrix(getattr(terms, k)).toarray() for k in MATRICES)])
    for ours, reference in zip(*found, strict=True):
        np.testing.assert_allclose(ours, reference, rtol=0, atol=1e-12 * np.abs(reference).max())


MATRICES = ("I_acc", "I_q", "A_q", "A_v")
