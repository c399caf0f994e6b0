"""The skin of the wing from 0.05 to 50 mm and from 1 Pa to 1e13 Pa: closed forms, laws of scaling, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.scenes import MODELS, WING
from toolkit.analyses.modes import solve_modes
from toolkit.analyses.statics import solve_statics
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import Flexible
from toolkit.components.loads.point_force import PointForce
from toolkit.description.design import BodyPoint
from toolkit.description.run_options import RunOptions
from toolkit.files.scene_reader import read_scene
from toolkit.foundation.errors import ConvergenceError, CriticalPointError
from toolkit.reduced_model.file import load
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.deformation import deformation

THICKNESSES = [0.05, 0.15, 0.5, 1.5, 5.0, 15.0, 50.0]
NOMINAL, MODULUS, TORQUE = 1.5, 70000.0, 4200.0
MODULI = [1e-6, 1.0, 1e3, 1e7]
"""MPa: from 1 Pa to 1e13 Pa."""


def skin(thickness: float, force: float) -> Scene:
    """The skin alone, clamped at F, with a force across its other end."""
    return Scene(
        units="mm-t-s",
        directory=MODELS,
        points={"G": BodyPoint(body="skin", interface="G")},
        bodies={"skin": Flexible(model="skin.h5", frame="grounded", thickness=thickness)},
        loads={"push": PointForce(body="skin", point="G", force=(0.0, force))},
    )


def compliance(thickness: complex) -> complex:
    """Deflection per force at the end of a polygon of straight beams, by the principle of virtual forces.

    sum over elements of L (M_1^2 + M_1 M_2 + M_2^2) / (3 E I) + N^2 L / (E A), M and N of a unit force.
    """
    model = load(MODELS / "skin.h5", ("mesh",))
    nodes, width = model.mesh.nodes, model.nominal["width"]
    along = np.diff(nodes, axis=0)
    length, moment = np.hypot(*along.T), nodes[-1, 0] - nodes[:, 0]
    one, two, pull = moment[:-1], moment[1:], along[:, 1] / length
    bending, tension = MODULUS * width * thickness**3 / 12, MODULUS * width * thickness
    return ((one**2 + one * two + two**2) * length / (3 * bending) + pull**2 * length / tension).sum()


@pytest.mark.parametrize("thickness", THICKNESSES)
def test_the_skin_alone_bends_and_stretches_as_virtual_forces_say(thickness):
    force = 1e-6 * (thickness / NOMINAL) ** 3
    system = compile_scene(skin(thickness, force), ["bodies.skin.thickness"])
    run, where = solve_statics(system), -2  # y of the last node
    # tension is 12 (l/t)^2 times as stiff as bending, times n^4 for the chain: 1e9 at 1.5 mm. Round-off of it, 1e-16 x 1e9 (1.5 / t)^2
    error = 1e-7 * max(NOMINAL / thickness, 0.01) ** 2
    assert run.q[0, where] == pytest.approx(compliance(thickness) * force, rel=error)
    slope = compliance(thickness + 1e-20j).imag / 1e-20 * force
    assert run.dq[0, where, 0] == pytest.approx(slope, rel=error)


def test_a_thin_skin_swings_in_proportion_to_its_thickness():
    """omega^2 ~ E t^2 / (rho L^4) of an inextensible chain; stretching enters with (t/L)^2."""
    found = [solve_modes(solve_statics(compile_scene(skin(t, 0.0))), 1).frequencies[0] / t for t in THICKNESSES]
    np.testing.assert_allclose(found[:3], found[0], rtol=1e-5)  # (0.5 mm / 80 mm)^2 / 12 = 3e-6
    np.testing.assert_allclose(found[3:], found[0], rtol=1e-2)  # (50 mm / 250 mm)^2 / 4
    change = (found[0] - np.array(found[4:])) / np.array(THICKNESSES[4:]) ** 2
    np.testing.assert_allclose(change / change[0], 1, rtol=0.05)  # that square itself; the next power is (50 mm / 250 mm)^2 of it


def scaled(thickness: float) -> Scene:
    """The wing with a torque that bends it alike, over a time that is as many of its periods."""
    k = thickness / NOMINAL
    changes = {"bodies.skin.thickness": thickness, "loads.drive.torque": TORQUE * k**3, "loads.drive.curve.duration": 1 / k}
    changes |= {"solver.end_time": 1.2 / k, "solver.step": 0.05 / k}
    return read_scene(WING, {key: repr(value) for key, value in changes.items()})


@pytest.mark.parametrize("kind", [solve_statics, simulate])
def test_the_wing_with_a_torque_like_the_cube_of_its_thickness_moves_alike(kind):
    """Inextensible bending: the angle of the drive is angle_0 + c t^2 + O(t^4)."""
    angles = np.array([kind(compile_scene(scaled(t))).q[-1, 92] for t in THICKNESSES])
    # statics to round-off of the thin skin, as above; in motion masses of rods do not thin out with the skin
    np.testing.assert_allclose(angles[:2], angles[0], rtol=3e-6)  # c t^2 is 1e-6 there
    change = (angles[3:] - angles[0]) / np.square(THICKNESSES[3:])
    # the round-off above over c t^2 = 6e-5 at 1.5 mm; the next power at 50 mm, where the change is an eighth of the angle
    np.testing.assert_allclose(change / change[1], 1, rtol=0.1)


@pytest.mark.parametrize("thickness", [0.05, 0.15, 0.5])
def test_a_thin_wing_under_the_full_torque_is_refused_or_said_to_leave_small_deformations(thickness):
    system = compile_scene(read_scene(WING, {"bodies.skin.thickness": str(thickness)}))
    if thickness < 0.5:
        with pytest.raises(CriticalPointError):
            solve_statics(system)
    else:
        assert deformation(solve_statics(system), "skin").exceeded
    with pytest.raises(ConvergenceError, match=r"smaller solver.step|far too large"):
        simulate(system)


@pytest.mark.parametrize("thickness", [5.0, 15.0, 50.0])
def test_a_thick_wing_under_the_full_torque_hardly_moves_and_alike_in_statics_and_motion(thickness):
    system = compile_scene(read_scene(WING, {"bodies.skin.thickness": str(thickness)}))
    still, moving = (solve(system).q[-1, 92] for solve in (solve_statics, simulate))
    assert (
        0 < still * thickness**3 < 1.1 * 0.5034 * NOMINAL**3 * 5
    )  # a small angle is softer than half a radian, by less than five
    assert moving == pytest.approx(still, rel=1e-5)


def stiffened(modulus: float) -> dict[str, str]:
    """All forces of the wing in proportion to a modulus: elastic, of the drive, of inertia."""
    k = modulus / MODULUS
    densities = ["bodies.skin.density", *(f"bodies.body{n}.density" for n in (2, 3, 4, 5))]
    changes = {"bodies.skin.youngs_modulus": modulus, "loads.drive.torque": TORQUE * k}
    return {path: repr(value) for path, value in {**changes, **dict.fromkeys(densities, 2.7e-9 * k)}.items()}


@pytest.mark.parametrize("kind", [solve_statics, simulate])
@pytest.mark.parametrize("modulus", MODULI)
def test_modulus_loads_and_densities_together_change_the_forces_alone(modulus, kind):
    k = modulus / MODULUS
    ours, other = (kind(compile_scene(read_scene(WING, changes), ["t_w"])) for changes in ({}, stiffened(modulus)))
    for name, factor in (("q", 1), ("dq", 1), ("multipliers", k), ("dmultipliers", k)):
        expected = getattr(ours, name)
        # round-off of a skin that is 1e9 times stiffer in tension than in bending; of Newton's tolerance nothing is left
        np.testing.assert_allclose(
            getattr(other, name) / factor, expected, rtol=0, atol=5e-9 * np.abs(expected).max(), err_msg=name
        )


@pytest.mark.parametrize("modulus", MODULI)
def test_frequencies_go_with_the_root_of_the_modulus(modulus):
    changes = {"bodies.skin.youngs_modulus": repr(modulus), "loads.drive.torque": repr(TORQUE * modulus / MODULUS)}
    ours, other = (solve_modes(solve_statics(compile_scene(read_scene(WING, each))), 1) for each in ({}, changes))
    assert other.frequencies[0] / np.sqrt(modulus / MODULUS) == pytest.approx(
        ours.frequencies[0], rel=1e-6
    )  # round-off, as above


@pytest.mark.parametrize("modulus", [1e-6, 1.0])
def test_a_skin_of_jelly_under_the_full_torque_is_refused(modulus):
    system = compile_scene(read_scene(WING, {"bodies.skin.youngs_modulus": repr(modulus)}))
    with pytest.raises(ConvergenceError, match=r"no equilibrium near|bifurcation|limit point") as error:
        solve_statics(system)
    assert isinstance(error.value, CriticalPointError) == (modulus == 1.0)
    with pytest.raises(ConvergenceError, match=r"Newton stopped .*smaller solver.step"):
        simulate(system)


def test_a_skin_of_1e13_pa_moves_in_proportion_to_its_compliance():
    """With a small angle the linkage is linear: the same torque on a thousand times the stiffness."""
    small = [solve_statics(compile_scene(read_scene(WING, {"bodies.skin.youngs_modulus": repr(e)}))).q[0, 92] for e in (1e7, 1e8)]
    assert small[0] / small[1] == pytest.approx(10, rel=0.02)  # the second order of 0.0027 rad
    moving = simulate(compile_scene(read_scene(WING, {"bodies.skin.youngs_modulus": "1e7"})), RunOptions(end_time=1.2, step=0.05))
    assert moving.q[-1, 92] == pytest.approx(small[0], rel=1e-6)
