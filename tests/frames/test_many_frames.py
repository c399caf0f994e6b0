"""Closed forms and published values for beams of several frames, and the cost of many."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import ffrf
from tests.frames.test_cut_bodies import EI, SECTION, STRAIGHT, cantilever, in_space
from tests.models.beam_models import save_beam
from toolkit.analyses.sensitivity.preparation import prepare, solve
from toolkit.analyses.statics import solve_statics
from toolkit.foundation.errors import SingularSystemError
from toolkit.solvers import direct_solve
from toolkit.solvers.static import static_matrix
from toolkit.system.system import compile_scene
from toolkit.validity.bodies.deformation import node_places


def test_an_end_moment_rolls_a_cantilever_into_a_circle(tmp_path):
    """M = 2 pi EI / L: curvature 1 / R everywhere with R = L / 2 pi, so that the free end meets the clamped one, turned by 2 pi.

    Under a pure moment an element between chord frames turns by exactly M l / EI, so that the angle is right with any number; its chord
    keeps the length l of the arc and not 2 R sin(pi / n), a gap of the order (pi / n)^2 / 6 of the radius.
    """
    n = 16
    scene = cantilever(tmp_path, STRAIGHT, n, (0.0, 0.0), moment=2 * np.pi * EI)
    solution = solve_statics(compile_scene(scene))
    places = node_places(solution, "beam")[0]
    radius = 1 / (2 * np.pi)
    assert np.linalg.norm(places[-1] - places[0]) < 1e-9  # a closed polygon of equal sides
    centre = np.add(in_space((0.0, radius)), (0.3, -0.2))
    off = np.abs(np.linalg.norm(places - centre, axis=1) - radius) / radius
    assert off.max() < 2 * (np.pi / n) ** 2 / 3  # the polygon's radius, and the centre that it has moved
    turned = solution.q[-1, solution.coordinates("beam[16]")]
    assert turned[2] + turned[-1] - 0.4 == pytest.approx(2 * np.pi, abs=1e-9)


SPINNING = """units = "m-kg-s"
[points]
hub = { body = "beam", interface = "hub" }
tip = { body = "beam", interface = "tip" }
[bodies]
beam = { type = "flexible", model = "beam.h5", frames = [3, 7, 11], angular_velocity = OMEGA }
[joints]
hub = { type = "angle-driver", bodies = ["beam", "ground"], point = "hub", curve = { type = "polynomial", coefficients = [0.0, OMEGA] } }
pin = { type = "revolute", bodies = ["beam", "ground"], point = "hub" }
[responses]
out = { type = "displacement", body = "beam", point = "tip", component = "x" }
[solver]
end_time = 1.0
step = 0.01
equilibrium = "spinning"
"""


@pytest.mark.parametrize(("gamma", "published"), [(2, 4.1373), (5, 6.4495), (10, 11.2023)])
def test_four_frames_stiffen_a_beam_that_spins(tmp_path, gamma, published):
    """Flap frequency in parts of sqrt(EI / rho A L^4), hub radius 0: Wright et al., J. Applied Mechanics 49 (1982). It is that across the
    plane of the spin; in the plane f^2 is less by gamma^2. Four parts of one length leave 1.4 % at gamma = 10: the beam bends at its hub,
    where shorter ones belong. One frame lacks the stiffening and loses 15 % at gamma = 2, more than there is at 5."""
    section = replace(SECTION, damping_stiffness=0.0)
    unit = np.sqrt(EI / (section.density * section.thickness * section.width))
    omega = float(gamma * unit)
    save_beam(tmp_path / "beam.h5", STRAIGHT, section, {"hub": 0.0, "tip": 1.0})
    (tmp_path / "scene.toml").write_text(SPINNING.replace("OMEGA", repr(omega)))
    model = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml"))
    found = model.modes(count=1, spinning=True).frequencies[0]
    assert np.sqrt((2 * np.pi * found / unit) ** 2 + gamma**2) == pytest.approx(published, rel=0.01)
    places = node_places(model.statics().solution, "beam")[0]
    x = omega * np.sqrt(section.density / section.youngs_modulus)
    assert np.linalg.norm(places[-1] - places[0]) - 1 == pytest.approx(np.tan(x) / x - 1, rel=3e-3)  # 16 elements: 1 / 16^2 of it


@pytest.mark.parametrize("stable", [True, False])
def test_sparse_factors_of_many_frames_find_what_dense_ones_do(tmp_path, monkeypatch, stable):
    """The tip of a beam of 48 frames, and of one that buckles: sparse factors tell stable states alone, so that dense ones take over."""
    force = (0.0, EI) if stable else (-3.0 * EI, 1e-3 * EI)
    nodes = np.column_stack([np.linspace(0, 1, 49), np.zeros(49)])
    system = prepare(cantilever(tmp_path, nodes, 48, in_space(force)), ["t"])
    assert system.n >= direct_solve.SPARSE_FROM_UNKNOWNS
    found: list[object] = []
    sparse_factors = static_matrix.sparse_factors
    monkeypatch.setattr(static_matrix, "sparse_factors", lambda *given: found.append(sparse_factors(*given)) or found[-1])
    sparse = solve(system, "static")
    assert any(each is not None for each in found)
    assert stable == all(each is not None for each in found)
    for module in (direct_solve, static_matrix):
        monkeypatch.setattr(module, "SPARSE_FROM_UNKNOWNS", 10**6)
    dense = solve(system, "static")
    np.testing.assert_allclose(
        sparse.q, dense.q, atol=1e-9
    )  # both stop at round-off, which the stiffness against tension magnifies
    np.testing.assert_allclose(sparse.dq, dense.dq, atol=1e-7 * np.abs(dense.dq).max())
    assert sparse.load_steps == dense.load_steps


def test_joints_that_repeat_each_other_are_refused_among_many_unknowns_too(tmp_path):
    """Sparse factors of a singular matrix exist to round-off; their pivots tell."""
    scene = cantilever(tmp_path, np.column_stack([np.linspace(0, 1, 49), np.zeros(49)]), 48, (0.0, EI))
    pins: dict[str, Any] = {name: ffrf.plane.Revolute(bodies=("beam", "ground"), point="tip") for name in ("pin", "again")}
    with pytest.raises(SingularSystemError, match="repeat or contradict each other") as found:
        solve(prepare(scene.model_copy(update={"joints": pins})), "static")
    assert "again" in str(found.value)
    assert "beam at node 0" not in str(found.value)
