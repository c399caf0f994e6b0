"""Skins of many short elements: their stiffness grows with the fourth power of their number, and round-off must not grow with it."""

from __future__ import annotations

from shutil import copy

import numpy as np
import pytest

import ffrf
from preprocessing import build
from tests.models.scenes import MODELS, WING
from toolkit.analyses.sensitivity.methods import gradients_by
from toolkit.components.bodies.chain_strains import no_strains
from toolkit.foundation.errors import ConvergenceError, CriticalPointError
from toolkit.reduced_model.file import save
from toolkit.system import pattern
from toolkit.system.system import compile_scene

TIMES = 10
"""As many elements as the wing has; interface points stay at their places."""


@pytest.fixture(scope="module")
def fine(tmp_path_factory):
    """Model of the wing with a skin of 300 elements."""
    folder = tmp_path_factory.mktemp("fine")
    text = (MODELS / "skin.toml").read_text()
    for count in (10, 25, 30):
        text = text.replace(f"node = {count} ", f"node = {TIMES * count} ")
    (folder / "skin.toml").write_text(text.replace("elements = 30", f"elements = {TIMES * 30}"))
    for name in ("high_speed.dat", "low_speed.dat", "scene.toml"):
        copy(MODELS / name, folder)
    save(build(folder / "skin.toml"), folder / "skin.h5")
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml"))


def test_round_off_of_a_fine_skin_stays_below_the_tolerance(fine):
    run = fine.simulate()
    assert run.solution.correction <= fine.scene.solver.tolerance
    # steps and inertia leave 1e-6 between the end of the motion and the equilibrium there; both have their round-off
    assert run.values["drive_angle"] == pytest.approx(fine.statics().values["drive_angle"], rel=2e-5)


def test_statics_does_not_take_round_off_for_a_limit_point(monkeypatch):
    """Where it keeps Newton from the tolerance, nothing is said of a snap or of buckling."""
    monkeypatch.setattr("toolkit.components.bodies.flexible.chain_strains", lambda *_: no_strains())
    monkeypatch.setattr(pattern, "COMPENSATED_PART", 2.0)  # all products are summed as usual
    model = ffrf.compile(ffrf.read_scene(WING, {"solver.tolerance": "1e-13"}))
    with pytest.raises(
        ConvergenceError, match=r"round-off keeps statics from an equilibrium .* Nothing is critical there"
    ) as error:
        model.statics()
    assert not isinstance(error.value, CriticalPointError)


@pytest.mark.parametrize("step", [0.0, 1e-30j], ids=["compiled", "plain"])
def test_a_state_can_be_evaluated_without_the_stiffness_that_is_kept_in_its_factors(step):
    scene = ffrf.read_scene(WING)
    scene = (
        scene if step == 0 else scene.with_number("bodies.skin.youngs_modulus", scene.number("bodies.skin.youngs_modulus") + step)
    )
    system = compile_scene(scene)
    q, v, *_ = system.start()
    given = system.inputs(0.0, np.array([0.0, 0.0, 1.0])), q, v, np.zeros_like(q)
    whole, apart = (system.evaluate(*given, apart=each).A_q for each in (False, True))
    strained = system.plan.constant.strained
    assert np.abs(strained).max() > 0.5 * np.abs(whole).max()
    np.testing.assert_allclose(apart + strained, whole, rtol=0, atol=1e-15 * np.abs(whole).max())


NEARBY = 1.5 * (1 + 1e-9 * np.arange(7))
"""Thicknesses so close that nothing but round-off keeps values and gradients from straight lines: their bend is 1e-16."""
LOST = {"values": 1e-11, "gradients": 1e-9}
"""Largest part of a number that round-off may take: 3e-13 and 1e-11 were measured. Of products of the stiffness' own entries, each
rounded but once, it is 3e-9 and 1e-7."""


@pytest.mark.parametrize("what", LOST)
def test_round_off_of_a_fine_skin_is_that_of_its_strains(fine, what):
    model = ffrf.compile(fine.scene, variables=["t_w", "E"])
    runs = [model.simulate({"t_w": float(each)}, gradients=True) for each in NEARBY]
    for name in ("max_stress", "shape_rmse", "drive_angle"):
        found = [run.values[name] if what == "values" else run.gradients[name]["t_w"] for run in runs]
        line = np.polynomial.Polynomial.fit(NEARBY - 1.5, found, 1)
        assert np.abs(line(NEARBY - 1.5) - found).max() < LOST[what] * abs(found[0])


def test_gradients_of_statics_of_a_fine_skin_have_the_round_off_of_its_strains(fine):
    """1e-11 was measured; solved with the stiffness' own entries they are off by 4e-8."""
    model = ffrf.compile(fine.scene, variables=["t_w", "E"])
    runs = [model.statics({"t_w": float(each)}, gradients=True) for each in NEARBY]
    for name in ("max_stress", "shape_rmse", "drive_angle"):
        found = [run.gradients[name]["t_w"] for run in runs]
        line = np.polynomial.Polynomial.fit(NEARBY - 1.5, found, 1)
        assert np.abs(line(NEARBY - 1.5) - found).max() < LOST["gradients"] * abs(found[0])


@pytest.mark.parametrize("kind", ["static", "transient"])
def test_direct_gradients_and_the_adjoint_agree_of_a_fine_skin(fine, kind):
    """Some 1e-11 was measured of the largest stress; by entries of the stiffness it is 1e-7 in motions and 2e-8 in statics."""
    design = ["t_w", "E", "x_A"]
    direct, adjoint = (gradients_by(method, fine.scene, design, kind).gradients for method in ("direct", "adjoint"))
    for name, gradient in direct.items():
        assert adjoint[name] == pytest.approx(gradient, rel=1e-9)


def test_a_complex_step_of_statics_has_the_digits_of_exact_gradients(fine):
    """1e-12 was measured; with one solve of a skin's stiffness in complex numbers it was 3e-9."""
    design = ["t_w", "E", "x_A"]
    direct, judge = (gradients_by(method, fine.scene, design, "static").gradients for method in ("direct", "complex-step"))
    for name in ("max_stress", "shape_rmse", "drive_angle"):
        assert judge[name] == pytest.approx(direct[name], rel=1e-10)
