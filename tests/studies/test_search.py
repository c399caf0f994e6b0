"""When a search ends, how far it goes, and what is left to gain, in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from tests.models.closed_searches import search_of, searched
from toolkit.studies.optimization import program
from toolkit.studies.optimization.explored import LONGEST_FIRST_STEP, Cuts
from toolkit.studies.optimization.methods import METHODS
from toolkit.studies.optimization.program import Optimality, Values, promised
from toolkit.studies.optimization.search import MOST_TRANSFORMED_VARIABLES, REACHES, UNIMPORTANT_GAIN, EndRule, Renewal
from toolkit.studies.study_file import Search as SearchOptions


def valley(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A wall a hundred times as steep as the floor, which bends; least squares of 0.01 where the floor ends, at z_0 = 0.9."""
    off, bend = z[1] - 0.5 - 0.25 * np.sin(6 * z[0]), 1.5 * np.cos(6 * z[0])
    return np.array([30 * off, 0.3 * (z[0] - 0.9), 0.1]), np.array([[-30 * bend, 30.0], [0.3, 0.0], [0.0, 0.0]])


def squares(**options: object) -> tuple[float, bool]:
    """Where a search of the valley ends, in parts of the least, and whether it is said to be an optimum."""
    found = searched(valley, np.array([0.3, 0.1]), method="slsqp", **options)
    assert found.best is not None
    r = found.best.values[0]
    return float(r @ r / 0.01 - 1.0), found.arrived


def test_a_search_that_has_seen_steep_slopes_only_is_not_done_on_the_floor_of_a_valley(monkeypatch):
    assert squares() == (pytest.approx(0.0, abs=SearchOptions().optimality), True)
    monkeypatch.setattr(program, "promised", lambda *_: 0.0)
    above, said = squares()
    assert said  # by slopes alone the twelfth design is one
    assert above > 0.1


def test_a_search_that_is_cut_short_on_the_floor_says_that_it_is_no_optimum():
    above, said = squares(evaluations=14)
    assert above > 0.05
    assert not said


@pytest.mark.parametrize("start", [(0.3, 0.1), (0.2, 0.5)])
def test_the_interior_point_method_takes_the_curvature_of_a_bent_valley(start):
    """With limits as curved as the identity, and a barrier by slopes alone, it stood 9 per cent above the least after 100 designs; where it
    began anew at the best design only, the second start stood at three times the least."""
    found = searched(valley, np.array(start), method="trust-constr")
    assert (found.arrived, found.evaluations < 100) == (True, True)
    assert found.best is not None
    assert found.best.values[0] @ found.best.values[0] == pytest.approx(0.01, rel=SearchOptions().optimality)


@pytest.mark.parametrize(("off", "ahead"), [(0.01, True), (0.2, False)])
def test_a_search_begins_anew_farther_along_where_one_short_step_leads_back_to_the_floor(off, ahead):
    """A design beside the floor may be refused for its objective and be nearer to the optimum; what lies far off is not gone on from."""
    explored = search_of(valley, evaluations=10).explored
    floor, beside = (np.array([z, 0.5 + 0.25 * np.sin(6 * z)]) for z in (0.3, 0.6))
    beside[1] += off
    assert explored.functions(beside).f > explored.functions(floor).f
    assert np.array_equal(explored.stand(), floor)
    assert np.array_equal(explored.stand(METHODS["trust-constr"].near), beside if ahead else floor)


@pytest.mark.parametrize("start", [(0.1, 0.9), (0.1, 0.6)])
def test_a_search_goes_around_a_wall_whose_cut_leads_the_wrong_way(monkeypatch, start):
    """The plane in front of a failed design leaves the optimum behind it: a search that may never pass it creeps along the plane for some
    50 designs or more, how long is a matter of round-off."""

    def slope(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([z[0] - 0.9, 3 * (z[1] - 0.5), 0.1]), np.array([[1.0, 0.0], [0.0, 3.0], [0.0, 0.0]])

    def wall(z: np.ndarray) -> bool:
        return 0.4 < z[0] < 0.8 and z[1] > 0.52

    found = searched(slope, np.array(start), wall, method="mma")
    assert (found.arrived, found.failed) == (True, 1)
    assert found.best is not None
    assert found.best.design == pytest.approx([0.9, 0.5], abs=1e-3)
    monkeypatch.setattr(Cuts, "release", lambda *_: None)
    assert searched(slope, np.array(start), wall, method="mma").evaluations > 4 * found.evaluations


def test_only_planes_at_which_a_search_stands_are_forgotten():
    cuts = Cuts()
    assert cuts.add(np.zeros(2), np.array([1.0, 0.0]))
    assert cuts.add(np.zeros(2), np.array([0.0, 1.0]))
    cuts.release(np.array([0.49, 0.3]))

    def flat(z: np.ndarray) -> Values:
        return Values(0.0, np.zeros(2), np.empty(0), np.empty((0, 2)))

    def planes(cuts: Cuts) -> int:
        return len(cuts.around(flat)(np.array([0.9, 0.3])).c)

    assert cuts.around(flat)(np.array([0.9, 0.3])).c == pytest.approx([0.2])
    assert cuts.add(np.zeros(2), np.array([1.0, 0.0]))  # failed again: the next time it waits twice as long
    cuts.release(np.array([0.49, 0.3]))
    assert planes(cuts) == 2
    cuts.release(np.array([0.49, 0.3]))
    assert planes(cuts) == 1


def quadratic(z: np.ndarray, curvature: np.ndarray, least: np.ndarray, c: np.ndarray, dc: np.ndarray) -> Values:
    off = z - least
    return Values(off @ curvature @ off / 2, curvature @ off, c, dc, curvature)


@pytest.mark.parametrize(
    ("z", "gain"),
    [
        ([0.2, 0.2], 1.98),  # to (1/2, 1/2), where both together are at their limit
        ([0.5, 0.5], 0.0),
        ([0.0, 1.0], 0.5),  # along the limit
        ([0.5 + 1e-7, 0.5 + 1e-7], 0.0),  # beyond it by round-off
    ],
)
def test_what_a_quadratic_program_promises_is_all_that_it_holds(z, gain):
    """(z_0 - 2)^2 + (z_1 - 2)^2 with z_0 + z_1 <= 1 and z between 0 and 1."""
    at = np.array(z)
    values = quadratic(at, 2 * np.eye(2), np.full(2, 2.0), np.array([1 - at.sum()]), np.array([[-1.0, -1.0]]))
    assert promised(at, 1 - at, values) == pytest.approx(gain, rel=1e-9, abs=1e-12)


def test_where_the_floor_is_flat_bounds_say_how_far_it_falls():
    """Curvatures of 1e4, 1e-3 and none: the last two end at the bounds; a search's slopes tell none of it."""
    z, top, slope = np.full(3, 0.25), np.ones(3), np.array([0.0, -0.1, 0.02])
    curvature = np.diag([1e4, 1e-3, 0.0])
    values = Values(1.0, slope, np.empty(0), np.empty((0, 3)), curvature)
    assert promised(z, top - z, values) == pytest.approx(
        0.1 * 0.75 - 0.5e-3 * 0.75**2 + 0.02 * 0.25, rel=1e-6
    )  # FLATTEST 1e4 / 1e-3
    assert promised(z, top - z, values._replace(curvature=np.zeros((3, 3)))) == pytest.approx(
        0.08, rel=1e-3
    )  # round-off / FLATTEST
    assert promised(z, top - z, values._replace(df=np.zeros(3))) == 0.0
    assert promised(z, top - z, values._replace(curvature=None)) == 0.0


def left(residual: float, gain: float = 0.0, violation: float = 0.0) -> Optimality:
    return Optimality(residual, violation, np.empty(0), np.empty((2, 0)), gain)


def test_conditions_are_met_where_slopes_and_gain_and_violations_are_small():
    assert left(1e-4, 1e-4, 1e-7).met(1e-3, 1e-6)
    assert not left(2e-3).met(1e-3, 1e-6)
    assert not left(1e-4, 2e-3).met(1e-3, 1e-6)
    assert not left(1e-4, 0.0, 2e-6).met(1e-3, 1e-6)
    assert left(0.4, 1e-9).met(1e-3, 1e-6)  # all designs stand at the optimum, so that its slopes are as large as others
    assert not left(0.4, 1e-5).met(1e-3, 1e-6)


MET, FAR = left(1e-4), left(1e-1)


@pytest.mark.parametrize(
    ("curved", "visited", "ends"),
    [
        (False, [(1.0, MET), (0.5, MET)], [False, True]),  # met again
        (True, [(1.0, MET), (0.5, MET), (0.5, MET)], [False, False, True]),  # of mean squares, not while something is gained
        (True, [(1.0, MET), (1.0 - 0.5 * UNIMPORTANT_GAIN, FAR)], [False, True]),
        (True, [(1.0, MET), (1.0 - 2.0 * UNIMPORTANT_GAIN, FAR)], [False, False]),
        (True, [(1.0, MET), (0.5, FAR), (0.5, FAR)], [False, False, False]),  # a saddle was left
        (True, [(1.0, FAR), (1.0, FAR)], [False, False]),
        (True, [(1.0, MET), (1.0, left(1e-4, violation=1.0)), (1.0, MET)], [False, False, True]),  # beyond a limit nothing counts
    ],
)
def test_a_search_ends_at_the_second_design_that_gains_nothing(curved, visited, ends):
    rule = EndRule(SearchOptions(), curved)
    assert [rule.ends(objective, each, 1.0) for objective, each in visited] == ends


def test_a_rule_that_begins_elsewhere_has_met_nothing():
    rule = EndRule(SearchOptions(), True)
    assert not rule.ends(1.0, MET, 1.0)
    assert rule.met
    rule.forget()
    assert not rule.met
    assert not rule.ends(1.0, MET, 1.0)


def test_the_first_step_is_halved_where_one_was_too_long_and_doubled_where_none_was():
    method, renewal = METHODS["mma"], Renewal(True, np.ones(3))
    assert renewal.every(method) == 1
    reaches = []
    for used in (2, 3, 4, 1, 1, 1, 1):  # one more than is renewed with is as it was
        renewal.adapt(method, used)
        reaches.append(renewal.reach / LONGEST_FIRST_STEP)
    assert reaches == [1.0, 0.5, 0.25, 0.5, 1.0, 2.0, 2.0]
    for _ in range(20):
        renewal.adapt(method, 9)
    assert renewal.reach == REACHES[0]


def test_learned_curvature_goes_as_far_as_ever_and_many_variables_are_never_renewed():
    learned = Renewal(False, np.ones(3))
    learned.adapt(METHODS["slsqp"], 99)
    assert learned.reach == LONGEST_FIRST_STEP
    assert (learned.every(METHODS["slsqp"]), learned.every(METHODS["mma"])) == (10, None)
    assert Renewal(True, np.ones(MOST_TRANSFORMED_VARIABLES + 1)).every(METHODS["slsqp"]) is None
