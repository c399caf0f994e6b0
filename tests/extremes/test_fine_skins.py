"""Skins of many short elements, whose stiffness grows with the fourth power of their number and round-off with it."""

from __future__ import annotations

from shutil import copy

import pytest

import toolkit as ffrf
from preprocessing import build
from tests.models.scenes import MODELS, WING
from toolkit.compilation.patterns import stiff_entries
from toolkit.foundation.errors import ConvergenceError, CriticalPointError
from toolkit.reduced_model.file import save

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
    monkeypatch.setattr(stiff_entries, "FELT", 2.0)  # all products are summed as usual
    model = ffrf.compile(ffrf.read_scene(WING, {"solver.tolerance": "1e-13"}))
    with pytest.raises(
        ConvergenceError, match=r"round-off keeps statics from an equilibrium .* Nothing is critical there"
    ) as error:
        model.statics()
    assert not isinstance(error.value, CriticalPointError)
