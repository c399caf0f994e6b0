"""Verdicts that are carried from design to design: against measures in closed form, and against those of single runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import toolkit as ffrf
from toolkit.api.outcome import MOST_KEPT_RUNS
from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.studies.carried_verdicts import (
    LARGEST_CARRYING_DISTANCE,
    ONE_VERDICT_DISTANCE,
    CarriedVerdicts,
    DesignAnswers,
    Indicators,
    Measured,
    apart,
    distances,
    growth,
    indicators,
    written_numbers,
)

BEAM = Path(__file__).parents[2] / "models" / "rotating_beam" / "beam.h5"
CANTILEVER = f"""
units = "m-kg-s"
[points]
tip = {{ body = "beam", interface = "tip" }}
[bodies]
beam = {{ type = "flexible", model = "{BEAM.as_posix()}", frame = "grounded" }}
[loads]
pull = {{ type = "point-force", body = "beam", point = "tip", force = [0.0, 1000.0] }}
[design]
F = "loads.pull.force.y"
[responses]
tip = {{ type = "displacement", body = "beam", point = "tip", component = "y" }}
[solver]
end_time = 1.0
step = 0.1
"""
WING = BEAM.parents[1] / "morphing_wing" / "scene.toml"
NOTHING = Indicators(np.zeros(0), np.zeros(0))


def test_a_distance_is_the_largest_change_beside_the_larger_number():
    one = Indicators(np.array([2.0, -1.0, 0.0, 1e-9]), np.array([0.0, 0.0, 0.0, 1e-3]))
    others = np.array(
        [one.numbers, [2.5, -1.0, 0.0, 1e-9], [2.0, 1.0, 0.0, 0.0], [2.0, -1.0, 1e-9, 0.0], [np.nan, -1.0, 0.0, 0.0]]
    )
    assert distances(one, others, np.tile(one.least, (5, 1))) == pytest.approx([0.0, 0.2, 2.0, 1.0, np.inf], abs=2e-6)
    assert distances(one, np.array([[2.0, -1.0, 0.0, 1e-4 + 1e-9]]), one.least[None]) == pytest.approx([0.1])


def map_by(designs: np.ndarray, shares: np.ndarray, told: np.ndarray) -> tuple[CarriedVerdicts, list[Verdict]]:
    """Verdicts of designs whose measures are known, with those that had to be measured."""
    verdicts = CarriedVerdicts(
        [NOTHING] * len(designs),
        {k: DesignAnswers(Indicators(each, np.zeros(len(each))), {}, {}) for k, each in enumerate(designs)},
    )
    while wanted := verdicts.wanted():
        for k in wanted:
            doubts = [Caution(f"code-{n}", f"{share:.6g}") for n, share in enumerate(shares[k]) if share > 1]
            verdicts.learn(k, Measured(Verdict.of(doubts), room_of(told[k]), None, {}))
    return verdicts, [verdicts.verdict(k) for k in range(len(designs))]


def room_of(shares: np.ndarray) -> float:
    return min((max(share, 1 / share) for share in shares), default=np.inf)


@pytest.mark.parametrize("spread", [0.02, 0.1, 0.3])
def test_doubts_are_those_that_measures_of_the_fourth_power_make(spread):
    random = np.random.default_rng(7)
    designs = np.exp(random.uniform(-spread, spread, (300, 3)))
    powers = np.array([[4.0, 0.0, 0.0], [2.0, -1.0, 1.0], [0.0, 1.0, -3.0], [-1.0, -1.0, -2.0]])
    shares = np.exp(np.log(designs) @ powers.T) * [1.03, 0.7, 1.7, 0.1]
    assert 0 < np.sum(shares[:, 0] > 1) < len(designs)
    verdicts, found = map_by(designs, shares, shares)
    for own, verdict in zip(shares, found, strict=True):
        assert {each.code for each in verdict.warnings if each.doubt} == {f"code-{n}" for n, share in enumerate(own) if share > 1}
    carried = {k: verdict.measures["carried"] for k, verdict in enumerate(found) if "carried-verdict" in verdict.codes}
    assert len(carried) == len(designs) - len(verdicts.measured)
    assert len(carried) > {0.02: 100, 0.1: 20, 0.3: 2}[spread]
    for k, source in carried.items():
        ratio = shares[k] / shares[source["design"]]
        assert np.all(np.maximum(ratio, 1 / ratio) <= growth(source["distance"]) * (1 + 1e-6))
        assert source["distance"] <= LARGEST_CARRYING_DISTANCE


def test_a_measure_that_is_not_known_is_silent_only_close_to_its_limit():
    """Designs around one that is right, of which those to one side are wrong: the farthest one is measured, and then all between."""
    designs = np.linspace(1.0, 1.14, 225)[:, None]
    shares = 0.8 * designs**4
    verdicts, found = map_by(designs, shares, np.zeros((len(designs), 0)))
    told = np.array([not verdict.trusted for verdict in found])
    missed = shares[told != (shares[:, 0] > 1)]
    assert np.all(np.maximum(missed, 1 / missed) < growth(ONE_VERDICT_DISTANCE))
    assert len(verdicts.measured) < len(designs) / 4


def test_designs_of_another_kind_or_without_numbers_are_near_nothing():
    alike = [DesignAnswers(Indicators(np.ones(2), np.zeros(2), (kind,)), {}, {}) for kind in (10, 10, 20)]
    verdicts = CarriedVerdicts([NOTHING] * 3, dict(enumerate(alike)))
    verdicts.learn(0, Measured(Verdict(), np.inf, None, {}))
    assert verdicts.source(1) == (0, 0.0)
    assert verdicts.wanted() == [2]
    written = [Indicators(np.array([x]), np.zeros(1)) for x in (1.0, 1.1, 2.0, np.nan, np.nan)]
    assert apart(written) == {0: True, 2: False, 3: False, 4: False}


@pytest.fixture(scope="module")
def cantilever(tmp_path_factory):
    path = tmp_path_factory.mktemp("beam") / "scene.toml"
    path.write_text(CANTILEVER)
    return ffrf.compile(ffrf.read_scene(path), variables=["F"])


def test_a_beam_that_bends_ever_farther_is_doubted_as_its_single_runs_are(cantilever):
    """From below the limits of large deformation and of geometric gradients, which values alone never pass, to beyond both."""
    designs = [{"F": force} for force in np.geomspace(1200.0, 2900.0, 22)]
    found, singles = (cantilever.map(designs, "statics", gradients=True, judged=judged) for judged in (True, "each"))
    carried = [each for each in found if "carried-verdict" in each.verdict.codes]
    assert len(carried) > 3
    for each, single in zip(found, singles, strict=True):
        assert (each.values, each.gradients) == (single.values, single.gradients)
        assert doubts_of(each.verdict) == doubts_of(single.verdict)
        told, own = ({c.code: c.part for c in verdict.warnings if c.body} for verdict in (each.verdict, single.verdict))
        assert all(own[code] / 2 < part < 2 * own[code] for code, part in told.items())
    assert len({doubts_of(each.verdict) for each in singles}) == 2
    assert f"designs[{carried[-1].verdict.measures['carried']['design']}]" in str(carried[-1].verdict)


def test_motions_of_a_wing_carry_what_is_told_of_values_gradients_and_steps():
    """A motion with peaks between steps, doubted for its deformation and for gradients whose signs are not known."""
    wing = ffrf.compile(ffrf.read_scene(WING), variables=["t_w", "x_A"])
    designs = [{"t_w": 1.5 * (1 + part)} for part in (0.0, 1e-4, 3e-4, 5e-4)]
    found, singles = (wing.map(designs, gradients=True, judged=judged) for judged in (True, "each"))
    assert ["carried-verdict" in each.verdict.codes for each in found] == [False, True, True, False]
    for each, single in zip(found, singles, strict=True):
        assert {*each.verdict.codes} - {"carried-verdict"} == {*single.verdict.codes} != set()
        assert doubts_of(each.verdict) == doubts_of(single.verdict)
        told, own = (verdict.measures["estimated_error"]["responses"] for verdict in (each.verdict, single.verdict))
        assert told == pytest.approx(own, rel=0.1, abs=1e-4)


def doubts_of(verdict: Verdict) -> frozenset[str]:
    return frozenset(each.code for each in verdict.warnings if each.doubt)


def test_each_verdict_is_measured_where_it_is_asked_for(cantilever):
    designs = [{"F": 1000.0}, {"F": 1001.0}]
    carried, measured = (cantilever.map(designs, "static", judged=judged) for judged in (True, "each"))
    assert [each.verdict.codes for each in carried] == [(), ("carried-verdict",)]
    assert [each.verdict for each in measured] == [cantilever.statics(each).verdict for each in designs]
    with pytest.raises(InputError, match='write True, False, or "each"'):
        cantilever.map(designs, judged="all")


def test_verdicts_are_the_same_wherever_and_however_often_designs_are_solved(cantilever, monkeypatch):
    designs = [{"F": force} for force in np.geomspace(500.0, 600.0, 8)]
    found = [each.verdict for each in cantilever.map(designs, "static")]
    assert [each.verdict for each in cantilever.map(designs, "static", threads=3)] == found
    monkeypatch.setattr("toolkit.api.outcome.MOST_KEPT_RUNS", 0)
    assert [each.verdict for each in cantilever.map(designs, "static")] == found
    assert len(designs) < MOST_KEPT_RUNS


def test_numbers_that_nobody_has_make_a_design_fail_and_are_near_nothing(cantilever):
    designs = [{"F": 1000.0}, {"chord": 1.0}, {"F": "much"}, {"F": 1000.5}]
    found = cantilever.map(designs, "static")
    assert [each.failed for each in found] == [False, True, True, False]
    assert found[3].verdict.measures["carried"]["design"] == 0


def test_indicators_follow_the_force_as_a_linear_beam_does(cantilever):
    """Deflection and its answers go with the force itself; the derivative stays."""
    one, other = (cantilever.statics({"F": force}, gradients=True) for force in (1000.0, 1100.0))
    parts = [indicators(each) for each in (one, other)]
    assert distances(parts[0], parts[1].numbers[None], parts[1].least[None]) == pytest.approx([1 / 11], rel=1e-6)
    written = written_numbers(cantilever.scene, [{"F": 1000.0}, {"F": 1100.0}])
    assert written[1].numbers == pytest.approx([1100.0])
    lost = indicators(replace(one, values={"tip": np.nan}))
    assert np.isinf(distances(parts[0], lost.numbers[None], lost.least[None]))


UPRIGHT = """units = "m-kg-s"
points = { P = [0.0, 0.0], C = [0.0, 1.0] }
bodies.bob = { type = "rigid", mass = 1.0, inertia = 1e-3, center = "C" }
joints.hinge = { type = "revolute", bodies = ["bob", "ground"], point = "P" }
loads.g = { type = "gravity", acceleration = [0.0, -9.81] }
loads.k = { type = "rotational-spring-damper", bodies = ["bob", "ground"], point = "P", stiffness = 9.81 }
design.k = "loads.k.stiffness"
responses.x = { type = "displacement", body = "bob", point = "C", component = "x" }
solver = { end_time = 60.0, step = 0.05 }
"""


@pytest.mark.parametrize("order", [1, -1])
def test_an_upright_pendulum_is_doubted_from_where_its_spring_is_too_soft_whatever_comes_first(tmp_path, order):
    """It stands from k = m g l on; a thousandth below it falls with exp(0.1 t)."""
    (tmp_path / "scene.toml").write_text(UPRIGHT)
    model = ffrf.compile(ffrf.read_scene(tmp_path / "scene.toml"), variables=["k"])
    parts = np.linspace(-0.005, 0.0055, 8)[::order]
    found = model.map([{"k": 9.81 * (1 + part)} for part in parts], gradients=True)
    falls = parts < -((np.log(100) / 60) ** 2) / 9.81  # by a hundredfold
    assert ["unstable-vibration" in each.verdict.codes for each in found] == falls.tolist()
    assert sum("carried-verdict" in each.verdict.codes for each in found) > 3
