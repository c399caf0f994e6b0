"""The spin-up of a flexible beam by a motor (Simo and Vu-Quoc, J. Applied Mechanics 53, 1986), with frames in number."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.linalg import eigh

import ffrf
from preprocessing import build, save
from tests.models.spatial_chains import chain_scene, save_chain
from toolkit.scene.resolution import resolve
from toolkit.validity.bodies.corotational_beams import compare_with_corotational
from toolkit.validity.bodies.critical_speed import spinning_bodies
from toolkit.validity.bodies.deformation import node_places
from toolkit.validity.bodies.physics import speed_limits
from toolkit.validity.snap_through import snap_through

LENGTH, EA, EI, MASS = 10.0, 2.8e7, 1.4e4, 1.2
SPEED, UP = 6.0, 15.0
ELONGATION = 5.14e-4
"""As they print it; m omega^2 L^3 / (3 EA) is 5.143e-4."""
MOTOR = """[joints]
bearing = { type = "revolute", bodies = ["beam", "ground"], point = "root" }
[joints.motor]
type = "angle-driver"
bodies = ["beam", "ground"]
point = "root"
[joints.motor.curve]
type = "product"
factors = [{ type = "constant", value = 6.0 }]
[joints.motor.curve.curve]
type = "sequence"
times = [15.0]
curves = [
    { type = "sum", terms = [
        { type = "polynomial", coefficients = [0.0, 0.0, 0.03333333333333333] },
        { type = "harmonic", offset = -0.3799544386587666, amplitude = 0.3799544386587666, frequency = 0.06666666666666667 },
    ] },
    { type = "polynomial", coefficients = [0.0, 1.0] },
]
[solver]
end_time = 18.0
step = 0.02
rho_inf = 0.9
"""


def angle(t):
    """Of the motor: up to T it is Omega / T (t^2 / 2 + (T / 2 pi)^2 (cos(2 pi t / T) - 1))."""
    rising = SPEED / UP * (t**2 / 2 + (UP / 2 / np.pi) ** 2 * (np.cos(2 * np.pi * t / UP) - 1))
    return np.where(t <= UP, rising, SPEED * (t - UP / 2))


def small_deflections(step: float, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of the tip across and along the turning axes by the theory of small deflections under the tension of the spin,

        m v'' + E I v'''' - (N v')' - m omega^2 v = -m omega' x,    N = m omega^2 (L^2 - x^2) / 2

    with four shapes out of eight polynomials and the trapezoidal rule: what it leaves out is of second order in v / L. Along them it is
    m omega^2 L^3 / (3 EA) less half of the integral of v'^2.
    """
    shapes = [Polynomial([0.0] * (k + 2) + [1.0]) for k in range(8)]

    def moment(p: Polynomial) -> float:
        return p.integ()(1.0)

    mass = np.array([[moment(a * b) for b in shapes] for a in shapes]) * MASS * LENGTH
    stiffness = np.array([[moment(a.deriv(2) * b.deriv(2)) for b in shapes] for a in shapes]) * EI / LENGTH**3
    tension = (
        np.array([[moment(a.deriv() * b.deriv() * Polynomial([0.5, 0, -0.5])) for b in shapes] for a in shapes]) * MASS * LENGTH
    )
    modes = eigh(stiffness, mass)[1][:, :4]
    slopes = modes.T @ np.array([[moment(a.deriv() * b.deriv()) for b in shapes] for a in shapes]) @ modes / LENGTH
    K, G = modes.T @ stiffness @ modes, modes.T @ (tension - mass) @ modes
    F, tip = modes.T @ [moment(a * Polynomial([0.0, 1.0])) for a in shapes] * MASS * LENGTH**2, modes.sum(axis=0)
    q, v, acc, found = *np.zeros((3, 4)), [(0.0, 0.0)]
    for t in step * np.arange(1, steps + 1):
        omega = SPEED / UP * (t - UP / 2 / np.pi * np.sin(2 * np.pi * t / UP)) if t <= UP else SPEED
        alpha = SPEED / UP * (1 - np.cos(2 * np.pi * t / UP)) if t <= UP else 0.0
        at = K + omega**2 * G
        predicted = q + step * v + step**2 / 4 * acc
        new = np.linalg.solve(np.eye(4) + step**2 / 4 * at, -at @ predicted - alpha * F)
        q, v, acc = predicted + step**2 / 4 * new, v + step / 2 * (acc + new), new
        found.append((float(tip @ q), MASS * omega**2 * LENGTH**3 / (3 * EA) - q @ slopes @ q / 2))
    across, along = np.array(found).T
    return across, along


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of twelve elements."""
    found = tmp_path_factory.mktemp("beam")
    thick = float(np.sqrt(12 * EI / EA))
    section = f'kind = "rectangle", thickness = {thick!r}, width = {1 / thick!r}'
    save_chain(found, np.column_stack([np.linspace(0, LENGTH, 13), np.zeros(13)]), section, EA)
    file = found / "frame.toml"
    text = file.read_text().replace("density = 1000.0", f"density = {MASS}")
    file.write_text(text.replace("[sections]", "[basis]\nspin_stiffening = true\n[sections]"))
    save(build(file), found / "beam.h5")
    return found


def tip(folder, body):
    """Times, and displacement of the tip along and across the turning axes; of a motion in which nothing snaps through."""
    solution = ffrf.compile(chain_scene(folder, body, MOTOR, 2)).simulate().solution
    assert not [*snap_through(solution)]
    x, y = node_places(solution, "beam")[:, -1].T
    turned = angle(solution.times)
    c, s = np.cos(turned), np.sin(turned)
    return solution.times, c * x + s * y - LENGTH, c * y - s * x


def test_the_tip_lags_behind_and_is_stretched(folder):
    """With four frames the lag is 1 % too large at its largest, because tension inside of the parts does not stiffen them; with twelve
    it is that of small deflections to the square of the slope, (0.57 / 10)^2."""
    lag, along = {}, {}
    for frames in (4, 12):
        times, along[frames], lag[frames] = tip(folder, f"frames = {frames}")
        assert along[frames][times >= UP].mean() == pytest.approx(ELONGATION, rel=3e-3)  # the beam still vibrates by some mm
    wanted, shorter = small_deflections(0.02, len(times) - 1)
    largest = np.abs(wanted).max()
    assert np.abs(lag[12] - wanted).max() < 4e-3 * largest
    assert np.abs(lag[12]).max() == pytest.approx(largest, rel=1e-3)
    assert along[12].min() == pytest.approx(shorter.min(), rel=4e-3)
    assert 0.005 * largest < np.abs(lag[4]).max() - largest < 0.012 * largest


def test_one_frame_runs_away_and_says_so(folder):
    early = MOTOR.replace(
        "end_time = 18.0", "end_time = 12.0"
    )  # later its deflection is too many times its length for any Newton
    verdict = ffrf.compile(chain_scene(folder, "frames = 1", early, 2)).simulate().verdict
    assert not verdict.trusted
    assert "critical-speed" in verdict.codes
    cut = resolve(chain_scene(folder, "frames = 4", MOTOR, 2))
    limits = speed_limits(cut, spinning_bodies(cut))  # one word for all parts, where a run fails
    assert limits.count("critical speed") == 1
    assert "the weakest part of beam" in limits


def test_one_frame_that_its_spin_stiffens_does_as_the_theory_of_small_deflections(folder):
    """Both are linear in the deflection: what is left is the tension of twelve elements, 1 / 144 of it, which is constant along each, and
    the trapezoidal rule. The shortening of the beam as it bends is of second order, and not in the place of its tip."""
    run = ffrf.compile(chain_scene(folder, "spin_stiffening = true", MOTOR, 2)).simulate()
    assert run.verdict.trusted
    times, along, lag = tip(folder, "spin_stiffening = true")
    wanted, _ = small_deflections(0.02, len(times) - 1)
    assert np.abs(lag - wanted).max() < 2e-3 * np.abs(wanted).max()
    assert along[times >= UP].mean() == pytest.approx(ELONGATION, rel=3e-3)


@pytest.mark.usefixtures("programs_here")
def test_check_deformation_knows_what_the_spin_stiffens(folder):
    """Under the same forces, of which the spin keeps back a part, elements that turn are off by the shortening of the beam alone."""
    solution = ffrf.compile(chain_scene(folder, "spin_stiffening = true", MOTOR, 2)).simulate().solution
    found = compare_with_corotational(solution, "beam")
    assert found.estimate.error == pytest.approx(found.error, rel=0.02)
    _, shorter = small_deflections(0.02, len(solution.times) - 1)
    assert found.error == pytest.approx(-shorter.min(), rel=0.02)
