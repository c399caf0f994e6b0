"""Critical loads of bodies in space: columns of Euler in any direction, strips that give way sideways, bars that never do."""

from __future__ import annotations

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import ffrf
from tests.models.spatial_chains import WHERE, chain_scene, save_chain
from toolkit.command_line.cli import app
from toolkit.validity.bodies.critical_load import compression

LENGTH, YOUNG, RATIO, ELEMENTS = 1.0, 1e9, 0.3, 8
AXIS = np.array([0.8, 0.48, -0.36])
CLAMPED = 'root = { type = "rigid", bodies = ["beam", "ground"], point = "root" }'
CROSS = "axes_of_cross = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"
PINNED = f"""root = {{ type = "universal", bodies = ["beam", "ground"], point = "root", {CROSS} }}
y = {{ type = "point-on-plane", bodies = ["beam", "ground"], point = "tip", axis = [0.0, 1.0, 0.0] }}
z = {{ type = "point-on-plane", bodies = ["beam", "ground"], point = "tip", axis = [0.0, 0.0, 1.0] }}"""
FORKED = f"""root = {{ type = "universal", bodies = ["beam", "ground"], point = "root", {CROSS} }}
slide = {{ type = "prismatic", bodies = ["block", "ground"], point = "tip", axis = [1.0, 0.0, 0.0] }}
end = {{ type = "universal", bodies = ["beam", "block"], point = "tip", {CROSS} }}"""
BLOCK = 'block = { type = "rigid", origin = "tip", mass = 1.0, center = "tip", inertia = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0] }\n'


class Bar:
    """A straight bar of one rectangle, of which the thinner side is y if it runs along x."""

    def __init__(self, folder, thickness: float, width: float, axis=(1.0, 0.0, 0.0)):
        self.folder = folder
        section = f'kind = "rectangle", thickness = {thickness}, width = {width}'
        save_chain(folder, np.linspace(0, LENGTH, ELEMENTS + 1)[:, None] * np.array(axis), section, YOUNG, RATIO)
        self.soft, self.stiff = (YOUNG * a * b**3 / 12 for a, b in ((width, thickness), (thickness, width)))
        of_torsion = 1 / 3 - 0.21 * thickness / width * (1 - (thickness / width) ** 4 / 12)  # Roark's formula for rectangles
        self.torsion = YOUNG / 2 / (1 + RATIO) * width * thickness**3 * of_torsion

    def under(self, force, point="tip", joints="", body='frame = "grounded"', bodies="", **loads):
        held = f"[joints]\n{joints}\n" if joints else ""
        others = "\n".join(f"{name} = {{ {text} }}" for name, text in loads.items())
        push = f'push = {{ type = "point-force", body = "beam", point = "{point}", force = {[float(f) for f in force]} }}'
        text = f"{bodies}{held}[loads]\n{push}\n{others}\n[responses]\n{WHERE}"
        return ffrf.compile(chain_scene(self.folder, body, text)).statics()


@pytest.fixture(scope="module")
def column(tmp_path_factory):
    """In a direction of its own."""
    return Bar(tmp_path_factory.mktemp("column"), 0.01, 0.02, AXIS)


@pytest.fixture(scope="module")
def straight(tmp_path_factory):
    """The same along x."""
    return Bar(tmp_path_factory.mktemp("straight"), 0.01, 0.02)


@pytest.fixture(scope="module")
def strip(tmp_path_factory):
    """Four hundred times as stiff one way as the other."""
    return Bar(tmp_path_factory.mktemp("strip"), 0.002, 0.04)


@pytest.mark.parametrize("part", [0.1, 0.9, 3.0])
@pytest.mark.parametrize(("body", "joints"), [('frame = "grounded"', ""), ('frame = "moving"', CLAMPED)])
def test_a_cantilever_has_the_load_of_euler(column, part, body, joints):
    euler = np.pi**2 * column.soft / 4
    found = compression(column.under(-part * euler * AXIS, joints=joints, body=body).solution)
    assert found.load == pytest.approx(part, rel=1e-5)  # cubic deflections: (pi h / 2 L)^4 / 720 = 2e-6
    assert found.missed == (pytest.approx(part / (1 - part), rel=1e-4) if part < 1 else np.inf)


@pytest.mark.parametrize("part", [0.1, 0.9])
def test_a_pinned_column_whose_frame_turns_has_the_load_of_euler(straight, part):
    euler = np.pi**2 * straight.soft
    found = compression(straight.under([-part * euler, 0, 0], joints=PINNED, body='frame = "moving"').solution)
    assert found.load == pytest.approx(part, rel=2e-4)  # levers are those of the compressed bar


def test_a_pinned_bar_whose_frame_turns_is_too_soft_under_tension(straight):
    """As in the plane: the frame that is tied to the bar's one end gives way at 3 EI / L^2."""
    part = 0.3
    run = straight.under([3 * part * straight.soft, 0, 0], joints=PINNED, body='frame = "moving"')
    found = compression(run.solution)
    assert found.load < 1e-6  # round-off
    assert found.feigned == pytest.approx(part / (1 - part), rel=1e-3)
    assert [each.code for each in run.verdict.warnings] == ["critical-load"]


def test_a_strip_with_a_force_at_its_tip_has_the_load_of_prandtl(strip):
    """4.0126 sqrt(EI GJ) / L^2 (Prandtl 1899, Michell 1899), of which one four-hundredth is lost before."""
    for part in (0.3, 1.1):
        found = compression(strip.under([0, 0, part * 4.0126 * np.sqrt(strip.soft * strip.torsion)]).solution)
        assert found.load == pytest.approx(part, rel=0.013)  # elements that are straight: 4 % with four of them, 1.2 % with eight
        assert found.load < part


def test_a_strip_between_forks_has_the_load_of_timoshenko(strip):
    """16.94 sqrt(EI GJ) / L^2 for a force at the middle (Timoshenko and Gere 1961, art. 6.3), here of a moving frame behind a block."""
    force = [0, 0, 0.9 * 16.94 * np.sqrt(strip.soft * strip.torsion)]
    run = strip.under(force, "middle", FORKED, 'frame = "moving"', BLOCK)
    assert compression(run.solution).load == pytest.approx(0.9, rel=0.013)
    assert any("beam is loaded with 0.89 times the critical load" in reason for reason in run.verdict.reasons)


def test_what_bends_a_bar_before_leaves_less_of_its_moment(straight):
    """sqrt((1 - EI_y / EI_z) (1 - GJ / EI_z)) of the load of Prandtl for a bar twice as wide as it is thick."""
    prandtl = 4.0126 * np.sqrt(straight.soft * straight.torsion)
    left = np.sqrt((1 - straight.soft / straight.stiff) * (1 - straight.torsion / straight.stiff))
    found = compression(straight.under([0, 0, 0.3 * prandtl]).solution)
    assert found.load == pytest.approx(0.3 * left, rel=0.02)  # one factor for both, and the elements' own error


def test_bars_that_are_bent_the_soft_way_never_give_way_sideways(tmp_path, strip):
    assert compression(strip.under([0, 0.3 * strip.soft, 0]).solution) is None
    square = Bar(tmp_path, 0.02, 0.02)
    for force in ([0, 0.6 * square.soft, 0], [0, 0.4 * square.soft, 0.4 * square.soft]):
        assert compression(square.under(force).solution) is None


def test_torques_about_axes_that_stay_do_not_buckle_a_shaft(straight):
    """Beck's and Ziegler's problem: no other equilibrium is near, whatever the torque."""
    turn = f'type = "torque", body = "beam", point = "tip", torque = [{0.5 * straight.torsion}, 0.0, 0.0]'
    run = straight.under([0.0, 0.0, 0.0], turn=turn)
    assert run.verdict.codes == ()


@pytest.mark.parametrize(
    ("part", "across", "said", "trusted"),
    [(0.02, 1e-3, 0, 1), (0.2, 0.0, 1, 1), (0.2, 1e-3, 1, 0), (0.6, 1e-3, 1, 0), (1.6, 0.0, 1, 0)],
)
def test_the_command_says_it(column, part, across, said, trusted):
    """What nothing turns aside is shortened as it should be, below the critical load."""
    column.under(np.pi**2 * column.soft / 4 * (across * np.array([0.0, AXIS[2], -AXIS[1]]) - part * AXIS))
    record = json.loads(CliRunner().invoke(app, ["statics", str(column.folder / "scene.toml"), "--json"]).stdout)
    texts = [each["text"] for each in record["warnings"] if each["code"] == "critical-load"]
    assert len(texts) == said
    assert record["verdict"]["trusted"] == trusted
