"""Joints whose line lies on a flexible body: doubted with the number of a force on the deformed body, silent where that is the same."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import ffrf
from tests.spatial.scenes import save_frame

EI = 1e9 * 0.02 * 0.02**3 / 12
"""In N m^2."""
BEAM = """units = "m-kg-s"
dimension = {d}
clamp = ["A"]
nodes = {{ A = {A}, M = {M}, B = {B} }}
beams = [{{ from = "A", to = "M", section = "s", elements = 10{across} }}, {{ from = "M", to = "B", section = "s", elements = 10{across} }}]
interface_points = {{ A = {{ node = "A" }}, M = {{ node = "M" }}, B = {{ node = "B" }} }}
sections.s = {{ kind = "rectangle", thickness = 0.02, width = 0.02, material = "m" }}
materials.m = {{ youngs_modulus = 1e9, density = 1.0{ratio} }}
"""
SCENE = """units = "m-kg-s"
dimension = DIMENSION
[points]
A = { body = "beam", interface = "A" }
M = { body = "beam", interface = "M" }
B = { body = "beam", interface = "B" }
[bodies]
beam = { type = "flexible", model = "beam.h5" }
block = { type = "rigid", mass = 1.0, center = "M", inertia = INERTIA }
[joints]
HELD
lead = { type = "position-driver", bodies = ["block", "ground"], point = "M", axis = [1.0, ZERO], curve = CURVE }
[loads]
w = { type = "point-force", body = "block", point = "M", force = [0.0, -1.0MORE] }
[responses]
x = { type = "displacement", body = "block", point = "M", component = "x" }
y = { type = "displacement", body = "block", point = "M", component = "y" }
[solver]
end_time = 4.0
step = 0.05
start = "equilibrium"
"""
PLANE = """pin = { type = "revolute", bodies = ["beam", "ground"], point = "A" }
roll = { type = "slider", bodies = ["beam", "ground"], point = "B", axis = [1.0, 0.0] }
guide = { type = "slider", bodies = ["block", "beam"], point = "M", axis = AXIS }
turn = { type = "angle-driver", bodies = ["block", "ground"], point = "M", curve = { type = "constant", value = 0.0 } }"""
SPACE = """root = { type = "rigid", bodies = ["beam", "ground"], point = "A" }
guide = { type = "prismatic", bodies = ["block", "beam"], point = "M", axis = [1.0, 0.0, 0.0] }"""


def model(folder: Path, led: str, dimension: int = 2, axis: str = "[1.0, 0.0]") -> ffrf.Model:
    """A bar of 1 m, between pins or in space a cantilever, under a block that is led along it from its middle and pushed down with 1 N."""
    zero = [0.0] * (dimension - 2)
    ends = {name: [x, 0.0, *zero] for name, x in (("A", 0.0), ("M", 0.5), ("B", 1.0))}
    across, ratio = (", orientation = [0.0, 0.0, 1.0]", ", poisson_ratio = 0.3") if zero else ("", "")
    save_frame(folder, "beam", BEAM.format(d=dimension, **ends, across=across, ratio=ratio))
    inertia = "[0.01, 0.01, 0.01, 0.0, 0.0, 0.0]" if zero else "0.01"
    text = SCENE.replace("DIMENSION", str(dimension)).replace("HELD", SPACE if zero else PLANE).replace("INERTIA", inertia)
    text = text.replace("ZERO", "0.0, 0.0" if zero else "0.0").replace("MORE", ", 0.0" if zero else "").replace("CURVE", led)
    (folder / "scene.toml").write_text(text.replace("AXIS", axis))
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml"))


def at(place: float) -> str:
    return f'{{ type = "smooth-step", height = {place}, start = 0.0, duration = 2.0 }}'


def between_pins(a: float) -> float:
    """w = F a^2 (L - a)^2 / (3 E I L) under a force at a of a bar between pins."""
    return -(a**2) * (1 - a) ** 2 / (3 * EI)


def told(run: ffrf.Run) -> float:
    """The number of y that the doubt gives."""
    (caution,) = (each for each in run.verdict.warnings if each.code == "line-on-flexible-body")
    found = re.search(r"y would be about (\S+) instead", caution.text)
    assert found
    return float(found[1])


def test_a_block_led_away_from_the_joint_is_told_where_the_deformed_bar_has_it(tmp_path):
    run = model(tmp_path, at(0.3)).statics()
    assert run.values["y"] < 3 * between_pins(0.8)  # as told by the tangent at the middle, and the arm from there
    assert told(run) == pytest.approx(between_pins(0.8), rel=0.01)


def test_a_block_that_stays_by_the_joint_is_right_and_not_doubted(tmp_path):
    run = model(tmp_path, at(0.02)).statics()
    assert run.values["y"] == pytest.approx(between_pins(0.52), rel=0.02)
    assert "line-on-flexible-body" not in run.verdict.codes


def test_a_slow_motion_is_told_as_the_equilibrium_it_ends_in(tmp_path):
    assert told(model(tmp_path, at(0.3)).simulate()) == pytest.approx(between_pins(0.8), rel=0.1)


def test_a_prismatic_joint_in_space_is_told_likewise(tmp_path):
    """A cantilever under a force at a: w = F a^3 / (3 E I)."""
    run = model(tmp_path, at(-0.3), 3).statics()
    assert run.values["y"] < 4 * -(0.2**3) / (3 * EI)
    assert told(run) == pytest.approx(-(0.2**3) / (3 * EI), rel=0.01)


def test_a_rail_that_leads_away_from_the_body_is_no_line_on_it(tmp_path):
    run = model(tmp_path, at(0.1), axis="[1.0, 1.0]").statics()
    assert "line-on-flexible-body" not in run.verdict.codes


FOLLOWED = """units = "m-kg-s"
dimension = DIMENSION
[points]
M = { body = "beam", interface = "M" }
Q = [0.2, HIGHZERO]
[bodies]
beam = { type = "flexible", model = "beam.h5", frame = "grounded" }
block = { type = "rigid", mass = MASS, center = "Q", inertia = INERTIA }
[joints]
rail = { bodies = ["block", "beam"], RAIL }
guide = { bodies = ["block", "ground"], point = "Q", GUIDE }
[loads]
w = { type = "point-force", body = "block", point = "Q", force = [0.0, -1.0ZERO] }
[responses]
y = { type = "displacement", body = "block", point = "Q", component = "y" }
ANSWER
"""
SLIDER = 'type = "slider", point = ["Q", "M"], axis = [1.0, 0.0]'
RAILS = {
    "slider": (2, "0.0", SLIDER),
    "disc": (2, "0.05", 'type = "rolling-disc", points = ["Q", "M"], axis = [1.0, 0.0]'),
    "driver": (
        2,
        "0.0",
        'type = "position-driver", point = ["Q", "M"], axis = [0.0, 1.0], curve = { type = "constant", value = 0.0 }',
    ),
    "plane": (3, "0.0", 'type = "point-on-plane", point = ["Q", "M"], axis = [0.0, 1.0, 0.0]'),
    "driver in space": (
        3,
        "0.0",
        'type = "position-driver", point = ["Q", "M"], axis = [0.0, 1.0, 0.0], curve = { type = "constant", value = 0.0 }',
    ),
}


def followed(folder: Path, rail: str, answer: str = "", mass: float = 1e-3, middle: float = 0.5) -> ffrf.Model:
    """A cantilever of 1 m under a block that stands at 0.2 m of it, on a rail whose point is at `middle`."""
    dimension, high, joint = RAILS[rail]
    zero = [0.0] * (dimension - 2)
    ends = {name: [x, 0.0, *zero] for name, x in (("A", 0.0), ("M", middle), ("B", 1.0))}
    across, ratio = (", orientation = [0.0, 0.0, 1.0]", ", poisson_ratio = 0.3") if zero else ("", "")
    save_frame(folder, "beam", BEAM.format(d=dimension, **ends, across=across, ratio=ratio))
    guide = 'type = "prismatic", axis = [0.0, 1.0, 0.0]' if zero else 'type = "slider", axis = [0.0, 1.0]'
    guide += "" if zero or rail == "disc" else ", lock_rotation = true"
    text = FOLLOWED.replace("DIMENSION", str(dimension)).replace("HIGH", high).replace("ZERO", ", 0.0" if zero else "")
    text = text.replace("INERTIA", "[1e-3, 1e-3, 1e-3]" if zero else "1e-3").replace("MASS", repr(mass)).replace("RAIL", joint)
    (folder / "scene.toml").write_text(text.replace("GUIDE", guide).replace("ANSWER", answer))
    return ffrf.compile(ffrf.read_scene(folder / "scene.toml"))


@pytest.mark.parametrize("rail", RAILS)
def test_what_stands_on_the_body_away_from_its_joint_is_told_where_the_deformed_bar_has_it(tmp_path, rail):
    """w = F a^3 / (3 E I) of a cantilever under a force at a = 0.2 m."""
    run = followed(tmp_path, rail).statics()
    assert run.values["y"] < 4 * -(0.2**3) / (3 * EI)
    assert told(run) == pytest.approx(-(0.2**3) / (3 * EI), rel=0.01)


@pytest.mark.parametrize("how", ["statics", "simulate"])
def test_the_largest_stress_is_told_along_the_deformed_bar(tmp_path, how):
    """F a / W at the clamp; of a motion, as the load sets in slowly."""
    model = followed(tmp_path, "slider", 's = { type = "max-stress", body = "beam" }')
    responses = {"s": model.scene.responses["s"]}
    solver = ffrf.RunOptions(end_time=1.0, step=0.05, quasi_static=True)
    run = getattr(ffrf.compile(model.scene.model_copy(update={"responses": responses, "solver": solver})), how)()
    (caution,) = (each for each in run.verdict.warnings if each.code == "line-on-flexible-body")
    found = re.search(r"s would be about (\S+) instead of (\S+)\.", caution.text)
    assert float(found[1]) == pytest.approx(0.2 / (0.02**3 / 6), rel=0.05)
    assert float(found[2]) > 1.4 * float(found[1])


def test_frequencies_are_told_of_a_rail_whose_point_is_where_the_block_stands(tmp_path):
    """Of a heavy block, in modes and as a response."""
    answer = 'f1 = { type = "frequency" }\nf2 = { type = "frequency", number = 2 }'
    true = followed(tmp_path, "slider", answer, 0.01, 0.2).modes(count=2)
    assert "line-on-flexible-body" not in true.verdict.codes
    model = followed(tmp_path, "slider", answer, 0.01)
    found, run = model.modes(count=2), model.statics()
    off = true.frequencies / found.frequencies - 1
    worst = int(abs(off).argmax())
    assert abs(off[worst]) > 0.5
    (caution,) = (each for each in found.verdict.warnings if each.code == "line-on-flexible-body")
    told = re.search(rf"mode {worst + 1} would be about (\S+) instead", caution.text)
    assert float(told[1]) == pytest.approx(true.frequencies[worst], rel=0.02)
    assert "line-on-flexible-body" in run.verdict.codes
