"""Bodies of one frame that their spin stiffens: published frequencies, balances of energy and momenta, gradients, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ffrf
from preprocessing import build, save
from tests.models.solid_bodies import DENSITY, MODULUS, box, cantilever, rectangle
from tests.spatial.momenta import kinetic_energy, momenta, momentum, strain_energy
from tests.spinning.scenes import BEAM
from tests.spinning.test_campbell import FLAP, diagram, lowest
from tests.spinning.test_spinning_gradients import same
from toolkit.api.comparison import check_design_derivatives, check_state_derivatives
from toolkit.api.model import compile_model
from toolkit.foundation.errors import InputError
from toolkit.scene.scene import Scene
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.bent_surfaces import geometric_errors
from toolkit.validity.energy_balance import energy_balance

ASKED = "spin_stiffening = true"
SPEEDS = (2.0, 5.0, 10.0)
ACROSS = np.array([FLAP[int(each)] for each in SPEEDS])
WITHIN = np.sqrt(ACROSS**2 - np.array(SPEEDS) ** 2)
MOTOR = """
[joints.axis]
type = "revolute"
bodies = ["blade", "ground"]
point = "root"
[joints.motor]
type = "angle-driver"
bodies = ["blade", "ground"]
point = "root"
curve = { type = "polynomial", coefficients = [0.0, 1.0] }
"""
TURNED = MOTOR.replace('point = "root"', 'point = "root"\naxis = [0.0, 0.0, 1.0]')


def scene(folder: Path, rest: str, body: str = ASKED, dimension: int = 2, root: str = "root", more: str = "") -> Scene:
    """A blade from blade.h5."""
    (folder / "scene.toml").write_text(
        f"""units = "m-kg-s"
dimension = {dimension}
[points]
root = {{ body = "blade", interface = "{root}" }}
tip = {{ body = "blade", interface = "tip" }}
{more}
[bodies]
blade = {{ type = "flexible", model = "blade.h5", {body} }}
{rest}"""
    )
    return ffrf.read_scene(folder / "scene.toml")


def round_bar(folder: Path, elements: int = 12, basis: str = ASKED) -> None:
    """That of `scenes.BEAM`, of one body."""
    text = BEAM.format(length=1.0).replace("elements = 1", f"elements = {elements}")
    (folder / "blade.toml").write_text(f"{text}[basis]\n{basis}\n")
    save(build(folder / "blade.toml"), folder / "blade.h5")


def test_one_beam_has_the_published_frequencies(tmp_path):
    """With the tension of every element constant along it, which lacks 1 / 144 of it, and its rotary inertia, 2e-6."""
    round_bar(tmp_path)
    spinning = scene(tmp_path, TURNED + '[solver]\nequilibrium = "spinning"\n', dimension=3)
    found = diagram(spinning, list(SPEEDS), 2)
    lag, flap = lowest(found).T
    np.testing.assert_allclose(flap, ACROSS, rtol=2e-3)
    np.testing.assert_allclose(lag, WITHIN, rtol=5e-3)
    assert not {"missing-stiffening", "critical-speed"} & set(found.verdict.codes)


def blade_of(folder: Path, dimension: int, cells: int = 12, count: int = 8) -> float:
    """Of solid elements, 1 m long and 20 mm high; its unit of frequencies sqrt(E I / rho A) / L^2 across its height."""
    mesh = rectangle("quad8", (cells, 1), 1.0, 0.02) if dimension == 2 else box("hexahedron20", (cells, 1, 1), (1.0, 0.03, 0.02))
    save(cantilever(folder, mesh, f'kind = "craig-bampton"\ncount = {count}\n{ASKED}', poisson_ratio=0.0), folder / "blade.h5")
    return float(np.sqrt(MODULUS * 0.02**2 / 12 / DENSITY))


@pytest.mark.parametrize("dimension", [2, 3])
def test_one_solid_has_them_too(dimension, tmp_path):
    """Shear and rotary inertia leave 5e-4 of a bar of slenderness 50, few modes 2e-3 of the soft motion at the highest speed."""
    unit = blade_of(tmp_path, dimension)
    rest = (MOTOR if dimension == 2 else TURNED) + '[solver]\nequilibrium = "spinning"\n'
    found = compile_model(scene(tmp_path, rest, dimension=dimension, root="hub")).campbell(
        [unit * each for each in SPEEDS], count=2
    )
    frequencies = 2 * np.pi * found.frequencies / unit
    if dimension == 2:
        np.testing.assert_allclose(frequencies[:, 0], WITHIN, rtol=3e-3)
    else:
        nearest = np.abs(frequencies - ACROSS[:, None]).argmin(axis=1)  # the softer ones in the plane of the spin cross it
        np.testing.assert_allclose(frequencies[np.arange(3), nearest], ACROSS, rtol=2e-3)
    assert not {"missing-stiffening", "critical-speed"} & set(found.verdict.codes)


FRAMES = {
    "plane": (2, ""),
    "space": (3, "orientation = [0.3, -0.2, 0.5]"),
    "turning": (3, 'frame = "turning", axis = [0.2, 1.0, 0.3], orientation = [0.3, 0.2, 0.1]'),
}


@pytest.fixture(params=FRAMES)
def free(request, tmp_path):
    """A stocky blade with some modes whose frame moves freely, or about an axis, and deforms as much as it likes."""
    dimension, body = FRAMES[request.param]
    mesh = rectangle("quad8", (3, 1), 1.0, 0.3) if dimension == 2 else box("hexahedron", (2, 1, 1), (1.0, 0.3, 0.2))
    save(cantilever(tmp_path, mesh, f'kind = "craig-bampton"\ncount = 3\n{ASKED}'), tmp_path / "blade.h5")
    return scene(tmp_path, "", f"{body}{', ' if body else ''}{ASKED}", dimension, "hub")


def test_derivatives_are_the_complex_step_of_the_residual(free):
    check_state_derivatives(free)
    check_design_derivatives(free)


def test_forces_of_velocities_work_as_the_kinetic_energy_grows(free):
    """v . h(q, v) = d/dt (v^T M(q) v / 2) at constant v, which makes any motion balance; it holds for no other form of the stiffening."""
    system = compile_scene(free)
    rng = np.random.default_rng(3)
    q = np.real(system.start()[0])
    n_q, size = system.n_q, free.bodies["blade"].frame_size
    q[size:n_q] = 0.05 * rng.normal(size=n_q - size)
    v, zero = np.where(np.arange(system.n) < n_q, rng.normal(size=system.n), 0.0), np.zeros(system.n)
    if size == 7:
        v[3:7] -= (v[3:7] @ q[3:7]) * q[3:7]  # the length of a quaternion stays
    given = system.inputs(0.0, np.zeros(3))
    by_inertia = system.matrix(system.evaluate(given, q, zero, v).I_q).toarray()
    part = system.plan.constant
    damped = np.sum(v[part.row] * part.damping * v[part.column])
    forces = (system.evaluate(given, q, v, zero).applied - system.evaluate(given, q, zero, zero).applied)[:n_q]
    assert v[:n_q] @ forces - damped == pytest.approx((v @ by_inertia @ v)[()] / 2, rel=1e-8)  # round-off of elastic forces
    assert stiffened_part(system, q, v) > 1e-4 * kinetic_energy(system, q[:n_q], v[:n_q])  # far more than the tolerance


def stiffened_part(system: Any, q: np.ndarray, v: np.ndarray) -> float:
    """How much less kinetic energy the body has because it is stiffened."""
    bodies = {"blade": system.scene.bodies["blade"].model_copy(update={"spin_stiffening": False})}
    plain = compile_scene(system.scene.model_copy(update={"bodies": bodies}))
    n_q = system.n_q
    return abs(kinetic_energy(plain, q[:n_q], v[:n_q]) - kinetic_energy(system, q[:n_q], v[:n_q]))


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_free_body_keeps_energy_and_momenta(dimension, tmp_path):
    """Of second order in the step, so that half of it leaves a quarter."""
    blade_of(tmp_path, dimension, cells=4, count=2)
    spin = "angular_velocity = 40.0" if dimension == 2 else "angular_velocity = [3.0, 20.0, 40.0]"
    start = "elastic_velocity = { tip = [0.0, 5.0] }" if dimension == 2 else "elastic_velocity = { tip = [0.0, 4.0, 5.0] }"
    lost = []
    for step in (4e-4, 2e-4):
        rest = f"[solver]\nend_time = 0.04\nstep = {step}\nrho_inf = 1.0\n"
        solution = ffrf.compile(scene(tmp_path, rest, f"{spin}, {start}, {ASKED}", dimension, "hub")).simulate().solution
        system, states = solution.system, list(zip(np.real(solution.q), np.real(solution.v), strict=True))
        energy = np.array([kinetic_energy(system, q, v) + strain_energy(system, q) for q, v in states])
        kept = np.array([momenta(system, q, v) if dimension == 3 else planar_momenta(system, q, v) for q, v in states])
        lost.append([np.abs(energy / energy[0] - 1).max(), np.abs(kept - kept[0]).max() / np.abs(kept[0]).max()])
    coarse, fine = np.array(lost)
    assert (fine < 0.3 * coarse).all()
    assert (fine < 1e-3).all()


def planar_momenta(system: Any, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Linear momentum, and angular momentum about the origin, (3,)."""
    x, y, turned = momentum(system, q, v)[:3]
    return np.array([x, y, q[0] * y - q[1] * x + turned])


@pytest.mark.parametrize("dimension", [2, 3])
def test_gradients_of_a_spin_up_and_its_energy(dimension, tmp_path):
    blade_of(tmp_path, dimension, cells=4, count=2)
    curve = '{ type = "polynomial", coefficients = [0.0, 0.0, 400.0] }'
    text = (MOTOR if dimension == 2 else TURNED).replace('{ type = "polynomial", coefficients = [0.0, 1.0] }', curve)
    asked = """[responses]
lag = { type = "displacement", body = "blade", point = "tip", component = "y" }
kinetic = { type = "kinetic-energy" }
[solver]
end_time = END
step = STEP
rho_inf = 0.8
tolerance = 1e-13
"""
    found = scene(tmp_path, text + asked.replace("STEP", "1e-3").replace("END", "4e-3"), dimension=dimension, root="hub")
    names = [f"bodies.blade.{name}" for name in ("density", "youngs_modulus", "poisson_ratio")]
    same(found, "transient", [*names, "joints.motor.curve.coefficients.2"], 1e-9)
    losses = []
    for step in ("1e-3", "5e-4"):
        solution = (
            ffrf.compile(
                scene(tmp_path, text + asked.replace("STEP", step).replace("END", "0.02"), dimension=dimension, root="hub")
            )
            .simulate()
            .solution
        )
        losses.append(energy_balance(solution).relative_defect)
    assert losses[1] < 0.3 * losses[0] < 0.01


def test_what_lacks_still_is_told(tmp_path):
    """A root half of the blade's length from the axis, against twelve frames, which know what that does."""
    round_bar(tmp_path)
    rest = f"""
hub = {{ type = "rigid", mass = 1.0, inertia = [1.0, 1.0, 1.0], center = "axis" }}
[joints.weld]
type = "rigid"
bodies = ["blade", "hub"]
point = "root"
{TURNED.replace('"blade"', '"hub"').replace('point = "root"', 'point = "axis"')}
[solver]
equilibrium = "spinning"
"""
    own, true = (
        diagram(scene(tmp_path, rest, body, 3, more="axis = [-0.5, 0.0, 0.0]"), [4.0], 2) for body in (ASKED, "frames = 12")
    )
    missed = 1 - lowest(own)[0, 1] / lowest(true)[0, 1]
    (caution,) = (each for each in own.verdict.warnings if each.code == "missing-stiffening")
    told = float(caution.text.split("by about ")[1].split("%")[0]) / 100
    assert told == pytest.approx(missed, rel=0.1)
    assert missed > 0.1
    assert caution.doubt


def test_one_frame_of_many_is_asked_for_in_vain(tmp_path):
    round_bar(tmp_path, 2, "")
    with pytest.raises(
        InputError, match=r"does not tell how a spin stiffens the body\. Write spin_stiffening = true in .* of blade\.toml"
    ):
        compile_scene(scene(tmp_path, TURNED, dimension=3))
    for body, words in (("frames = 2, ", "stiffens at its cuts"), ('frame = "grounded", ', "is that of a frame that turns")):
        with pytest.raises(InputError, match=words):
            scene(tmp_path, TURNED, body + ASKED, dimension=3)


def test_a_floating_blade_that_a_bearing_carries_round_is_not_trusted(tmp_path):
    """In free flight about its centre of mass it is; started about its end, whose force it knows nothing of, it is not."""
    text = BEAM.format(length=1.0).replace("elements = 1", "elements = 8").replace('clamp = ["root"]\n', "")
    (tmp_path / "blade.toml").write_text(f'{text}[basis]\nkind = "eigenmodes"\nboundary = "free"\ncount = 4\n{ASKED}\n')
    save(build(tmp_path / "blade.toml"), tmp_path / "blade.h5")
    solver = "[solver]\nend_time = 2e-3\nstep = 1e-4\n"
    held = TURNED.split("[joints.motor]")[0]
    spun = "angular_velocity = [0.0, 0.0, 40.0], velocity = [0.0, {}, 0.0]"
    flying = ffrf.compile(scene(tmp_path, solver, f"{spun.format(-20.0)}, {ASKED}", 3)).simulate()
    carried = ffrf.compile(scene(tmp_path, held + solver, f"{spun.format(0.0)}, {ASKED}", 3)).simulate()
    assert "missing-stiffening" not in flying.verdict.codes
    assert "missing-stiffening" in carried.verdict.codes
    assert not carried.verdict.trusted


def test_a_blade_that_its_weight_bends_across_its_spin(tmp_path):
    """One frame against twelve, whose elements lack the square of 1 / 12 of what stiffens; and elements that turn, of whose stiffening its
    own is no error, are found to be as near."""
    round_bar(tmp_path)
    rest = f"""{TURNED.replace("[0.0, 1.0]", "[0.0, 50.0]")}
[loads.weight]
type = "gravity"
acceleration = [0.0, 0.0, -20.0]
[responses]
z = {{ type = "displacement", body = "blade", point = "tip", component = "z" }}
[solver]
equilibrium = "spinning"
"""
    bodies = (ASKED, "frames = 12", "spin_stiffening = false")
    own, true, soft = (ffrf.compile(scene(tmp_path, rest, body, 3)).statics() for body in bodies)
    assert own.values["z"] == pytest.approx(true.values["z"], rel=5e-3)
    assert soft.values["z"] < 2 * true.values["z"]
    found = geometric_errors(own.solution)["blade"]
    assert found is not None
    assert found.relative < 0.01
    assert own.verdict.trusted
