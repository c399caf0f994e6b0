"""A free flexible body tumbles a thousand turns: energy, linear and angular momentum, and the length of its quaternion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from preprocessing.builders.frame_recipe import FrameRecipe
from tests.spatial.momenta import kinetic_energy, momenta, spin, strain_energy
from tests.spatial.quadrature import Motion, raw_frame, total
from tests.spatial.scenes import save_frame
from toolkit.analyses.transient import simulate
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.description.run_options import RunOptions
from toolkit.foundation.kinematics.orientation import matrix_of, quaternion_of
from toolkit.scene.scene import Scene
from toolkit.system.system import System, compile_scene

CORNERS = np.array([[0.0, 0.0, 0.0], [0.7, 0.0, 0.0], [0.7, 0.5, 0.0], [0.7, 0.5, 0.3]])
CENTRE = (0.7 * CORNERS[:2].sum(0) + 0.5 * CORNERS[1:3].sum(0) + 0.3 * CORNERS[2:].sum(0)) / 3
BENT = """units = "m-kg-s"
{clamp}
nodes = {{ {nodes} }}
beams = [
    {{ from = "A", to = "B", section = "rod", elements = 2 }},
    {{ from = "B", to = "C", section = "rod", elements = 1 }},
    {{ from = "C", to = "D", section = "rod", elements = 1 }},
]
sections = {{ rod = {{ kind = "circle", diameter = 0.02, material = "plastic" }} }}
materials = {{ plastic = {{ youngs_modulus = {modulus}, poisson_ratio = 0.25, density = 1000.0 }} }}
{basis}
"""
FREE = '[basis]\nkind = "eigenmodes"\ncount = 4\nboundary = "free"'
CLAMPED = '[basis]\nkind = "eigenmodes"\ncount = 4'
OMEGA = 2 * np.pi * np.array([0.3, 0.9, 0.2])
"""About one turn per second, about no principal axis; the lowest elastic modes are at 20, 40 and 60 Hz."""


def bent(origin: np.ndarray = CENTRE, basis: str = FREE, modulus: float = 1e10) -> str:
    """A bar bent twice, in space; frame.toml with its nodes seen from an origin."""
    nodes = ", ".join(f"{name} = {[float(x) for x in place]}" for name, place in zip("ABCD", CORNERS - origin, strict=True))
    return BENT.format(clamp="" if basis == FREE else 'clamp = ["A"]', nodes=nodes, modulus=modulus, basis=basis)


def tumbling(directory, text: str, **velocity) -> System:
    save_frame(directory, "bent", text)
    body = SpatialFlexible(model="bent.h5", frame="moving", **velocity)
    return compile_scene(Scene(units="m-kg-s", dimension=3, directory=directory, bodies={"bent": body}))


@pytest.mark.parametrize(("origin", "basis"), [(CENTRE, FREE), (0 * CENTRE - 0.1, CLAMPED), (0 * CENTRE, "")])
def test_energy_and_momenta_of_a_random_state_are_those_of_its_velocity_field(tmp_path, origin, basis):
    """v M v / 2 and M v of the compiled loop against Gauss points on the raw beams: mean axes, clamped modes, all nodal coordinates."""
    system, rng = tumbling(tmp_path, bent(origin, basis)), np.random.default_rng(5)
    raw, n_f = raw_frame(FrameRecipe.read(tmp_path / "bent.toml").file), system.n_q - 7
    for _ in range(3):
        q = np.concatenate([rng.normal(size=3), quaternion_of(rng.normal(size=3)), 0.1 * rng.normal(size=n_f)])
        v = rng.normal(size=system.n_q)
        v[3:7] -= q[3:7] * (q[3:7] @ v[3:7])
        exact = total(raw, Motion(q[:3], v[:3], matrix_of(q[3:7]), spin(q[3:7], v[3:7]), q[7:], v[7:]))
        # both are sums of some hundred products
        assert kinetic_energy(system, q, v) == pytest.approx(exact.energy, rel=1e-13)
        expected = np.concatenate([exact.linear, exact.angular])
        np.testing.assert_allclose(momenta(system, q, v), expected, rtol=0, atol=1e-13 * np.abs(expected).max())


class Losses(NamedTuple):
    """Largest changes since the start, relative to it, in the first ten and in the last ten of all turns."""

    energy: tuple[float, float]
    linear: tuple[float, float]
    angular: tuple[float, float]
    length: float  # of the quaternion, over all turns


def losses(system: System, options: RunOptions) -> Losses:
    run = simulate(system, options)
    ten = int(10 / run.times[1])
    windows = [[*range(0, ten, 2)], [*range(run.steps - ten, run.steps + 1, 2)]]
    states = [[(run.q[n], run.v[n]) for n in window] for window in windows]
    energies = [np.array([kinetic_energy(system, q, v) + strain_energy(system, q) for q, v in each]) for each in states]
    found = [np.array([momenta(system, q, v) for q, v in each]) for each in states]
    start = found[0][0]
    energy = tuple(float(np.abs(each / energies[0][0] - 1).max()) for each in energies)
    linear, angular = (
        tuple(float(np.linalg.norm((each - start)[:, part], axis=1).max() / np.linalg.norm(start[part])) for each in found)
        for part in (slice(0, 3), slice(3, 6))
    )
    return Losses(energy, linear, angular, float(np.abs(np.sum(run.q[:, 3:7] ** 2, axis=1) - 1).max()))


@pytest.mark.parametrize(("formulation", "rho_inf"), [("ggl", 1.0), ("index-1", 0.8)])
def test_a_thousand_turns_keep_energy_and_momenta_to_second_order(tmp_path, formulation, rho_inf):
    """Undamped they stay where the first turns brought them; numerical damping moves them on, slower by a higher power of the step."""
    system = tumbling(tmp_path, bent(), angular_velocity=tuple(OMEGA), velocity=(1e-3, 2e-3, -1e-3))
    coarse, fine = (
        losses(system, RunOptions(end_time=1000.0, step=1 / n, rho_inf=rho_inf, formulation=formulation, tolerance=1e-12))
        for n in (16, 32)
    )
    for early, late in ((coarse.energy, fine.energy), (coarse.angular, fine.angular)):
        assert early[0] / late[0] == pytest.approx(4.0, rel=0.1)
        assert late[0] < 2.5e-3  # (2 pi / 32)^2 / 12 = 3.2e-3
        if rho_inf == 1:
            assert late[1] < 1.2 * late[0]
            assert early[1] / late[1] > 3.6
        else:
            assert late[1] < 0.025
            assert early[1] / late[1] > 5.6  # order 2.5 and more
    # mean axes with their origin in the centre of mass: the frame's place is that of all mass, and no force acts
    assert max(*coarse.linear, *fine.linear) < 1e-12
    assert fine.length < 1e-14 if formulation == "ggl" else coarse.length / fine.length > 7  # third order by Baumgarte's terms
