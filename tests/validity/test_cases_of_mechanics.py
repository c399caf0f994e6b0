"""Mechanisms whose right values are known from elsewhere: runs give them and are trusted, or are doubted with how far they are off.

The values are closed forms, published ones, or those of finite elements with geometric stiffness and with a design's own shapes.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

import ffrf
from preprocessing import build, save
from toolkit.foundation.errors import ConvergenceError
from toolkit.scene.changed_numbers import with_numbers

CASES = Path(__file__).parents[1] / "data" / "mechanics"
MODELS = {
    "tension": ("frame",),
    "pinned": ("cbchord", "p_full"),
    "parametric": ("frame",),
    "flutter": ("frame",),
    "mass_damping": ("clamp", "chord", "mean"),
    "shear": ("frame",),
    "false_doubt_bar": ("body",),
    "step_annihilates": ("short",),
    "frozen_basis": ("blade_frozen",),
    "hanging_bar": ("frame",),
}
"""Case -> inputs of its reduced models."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("mechanics") / "cases"
    shutil.copytree(CASES, found)
    return found


def run(folder, case: str, scene: str, how: str, numbers: dict[str, float] | None = None):
    """A run with gradients where the scene has design variables."""
    for name in MODELS.get(case, ()):
        path = folder / case / f"{name}.h5"
        if not path.exists():
            save(build(path.with_suffix(".toml")), path)
    read, _ = with_numbers(ffrf.read_scene(folder / case / f"{scene}.toml"), numbers or {})
    variables = [] if how == "modes" else list(read.design)
    model = ffrf.compile(read, variables=variables)
    return model.modes(count=4) if how == "modes" else getattr(model, how)(gradients=bool(variables))


def doubts(found) -> dict[str, str]:
    """Code -> text of the doubts about a run."""
    return {each.code: each.text for each in found.verdict.warnings if each.doubt}


RIGHT = [
    ("tension", "canti_eight", "statics", "f1", 1.14074),
    ("mass_damping", "scene_clamp", "statics", "z1", 0.01622),
    ("mass_damping", "scene_chord", "statics", "z1", 0.01622),
    ("false_doubt_bar", "scene", "statics", "w", 1.457e-7),
    ("free_spin", "scene", "simulate", "f2", 0.716848),
    ("free_spin", "second", "simulate", "f2", 0.716848),
    ("friction_creep", "scene", "simulate", "x", 7.03403e-3),  # 7.03403e-4 in a second, for ten
    ("far_assembly", "space", "statics", "turn", 3.0),
    ("far_assembly", "plane", "statics", "turn", 3.0),
    ("hanging_bar", "hang", "statics", "f1", (9.81 * 0.5 / (1 / 3 + 0.1**2 / 12)) ** 0.5 / 6.283185307179586),
]


@pytest.mark.parametrize(("case", "scene", "how", "response", "value"), RIGHT, ids=[f"{row[0]} {row[1]}" for row in RIGHT])
def test_a_right_value_is_trusted(folder, case, scene, how, response, value):
    found = run(folder, case, scene, how)
    assert found.values[response] == pytest.approx(value, rel=0.003)  # 0.2 % of canti_eight, by its eight frames
    assert doubts(found) == {}


DOUBTED = {
    "a pulled cantilever": ("tension", "canti_one", "statics", "tension", r"f1 by ([\d.]+)%", 100 * (1 - 0.55959 / 1.14074)),
    "a pulled bar": ("tension", "scene_one", "statics", "tension", r"f1 by ([\d.]+)%", 100 * (1 - 3.56084 / 4.34083)),
    "a pinned bar": ("pinned", "chord", "statics", "tension", r"displacement is ([\d.]+) times", 14.286 / 6.536),
    "a pinned bar's derivative": ("pinned", "chord", "statics", "tension", r"up to ([\d.]+) times", 7.143e-5 / 1.593e-5),
    "a clamped bar": ("pinned", "clamped_one", "statics", "tension", r"displacement is ([\d.]+) times", 12.639 / 8.390),
    "an alternating force": (
        "parametric",
        "frames_1",
        "simulate",
        "parametric-resonance",
        r"up to ([\d.]+) times",
        0.83 / 5.57e-3,
    ),
    "Beck's column": ("flutter", "scene_25", "modes", "merging-vibrations", r"exp\(([\d.]+) t\)", 4.917),
    "Beck's column at rest": ("flutter", "scene_25_nofreq", "statics", "unstable-vibration", r"exp\(([\d.]+) t\)", 4.917),
    "Ziegler's pendulum": ("damped_flutter", "scene", "statics", "unstable-vibration", r"exp\(([\d.]+) t\)", 0.01452),
    "a short beam": ("shear", "scene", "statics", "shear", r"f5 .*?some ([\d.]+)%", 100 * (2659.0 / 2321.2 - 1)),
    "its derivative": ("shear", "scene", "statics", "shear", r"f5 .*?by ([\d.]+)%", 100 * (23763 / 16050 - 1)),
    "a sudden load": (
        "step_annihilates",
        "short_scene",
        "simulate",
        "lost-vibrations",
        r"stress is .*?, ([\d.e+]+) with",
        146.5e6,
    ),
    "a mass let go": ("step_annihilates", "scene", "simulate", "lost-vibrations", r"F is .*?, ([\d.]+) with", 0.0198),
    "a frozen basis": ("frozen_basis", "scene_frozen", "statics", "frozen-basis", r"ty by tr is off by ([\d.]+)%", 14.0),
}


@pytest.mark.parametrize("name", DOUBTED)
def test_a_wrong_value_is_doubted_with_how_wrong_it_is(folder, name):
    """Within a factor of two."""
    case, scene, how, code, pattern, right = DOUBTED[name]
    text = doubts(run(folder, case, scene, how))[code]
    assert 0.5 < float(re.search(pattern, text)[1]) / right < 2


def test_a_frozen_basis_far_from_its_design_is_doubted_in_values_and_gradients(folder):
    text = doubts(run(folder, "frozen_basis", "scene_frozen", "statics", {"bodies.blade.thickness_outer": 0.25}))["frozen-basis"]
    assert float(re.search(r"f2 is off by ([\d.]+)%", text)[1]) == pytest.approx(48, abs=1)
    assert "f2 by to" in text


def test_linkages_that_cannot_go_on_or_close_say_where(folder):
    with pytest.raises(ConvergenceError, match=r"-0\.021[78]\d* rad"):
        run(folder, "locking_linkage", "scene", "simulate", {"joints.motor.curve.height": -0.8})
    with pytest.raises(ConvergenceError, match=r"'link' is open by 0\.25 m"):
        run(folder, "link_too_short", "scene", "simulate")
