"""Gears, pinions and discs are drawn as circles that touch, with a spoke that turns with the body."""

from __future__ import annotations

import numpy as np
import pytest

from ffrf import plane
from tests.joints.test_gears import disc, geared_wheels, planetary, run, spatial_wheels
from toolkit.render.plane.configuration import Configuration
from toolkit.render.space.configuration import SpatialConfiguration


def centres_and_radii(wheels: list[np.ndarray]) -> list[tuple[np.ndarray, float]]:
    found = []
    for wheel in wheels:
        distances = np.linalg.norm(wheel[1:] - wheel[0], axis=1)
        np.testing.assert_allclose(distances, distances[0], rtol=1e-9)  # round-off
        found.append((wheel[0], distances[0]))
    return found


def test_pitch_circles_touch_and_turn():
    found = run(geared_wheels(plane.Gear(bodies=("small", "large"), points=("A", "B"), teeth=(17, 51))), end_time=1.0)
    moment = Configuration(found, len(found.times) - 1)
    (a, small), (b, large) = centres_and_radii(moment.wheels())
    assert small + large == pytest.approx(np.linalg.norm(b - a), rel=1e-9)
    assert large == pytest.approx(3 * small, rel=1e-9)
    for wheel, angle in zip(moment.wheels(), found.q[-1, [2, 5]], strict=True):
        spoke = (wheel[1] - wheel[0]) / np.linalg.norm(wheel[1] - wheel[0])
        np.testing.assert_allclose(spoke, [np.cos(angle), np.sin(angle)], atol=1e-9)  # round-off
    assert moment.links() == []


def test_a_ring_is_drawn_round_its_planet():
    found = run(planetary(0.3, 0.1, ring=True), end_time=0.1)
    (planet, small), (ring, large) = centres_and_radii(Configuration(found, 3).wheels())
    assert large - small == pytest.approx(np.linalg.norm(ring - planet), rel=1e-6)  # what the joints are off by


def test_a_disc_is_drawn_with_its_radius():
    found = run(disc(plane.RollingDisc, 0.3), end_time=0.1)
    ((_, radius),) = centres_and_radii(Configuration(found, 3).wheels())
    assert radius == pytest.approx(0.3, rel=1e-9)


def test_wheels_in_space_lie_across_their_axis():
    scene = spatial_wheels((17, 51))
    found = run(scene, end_time=0.1)
    moment = SpatialConfiguration(found, 5)
    axis = np.array(scene.joints["gear"].axis)
    (_, small), (_, large) = centres_and_radii(moment.wheels())
    assert [small, large] == pytest.approx([0.1, 0.3], rel=1e-6)
    for wheel in moment.wheels():
        np.testing.assert_allclose((wheel - wheel[0]) @ axis, 0, atol=1e-7)  # what the joints are off by
