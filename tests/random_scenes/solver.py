"""How a random scene is solved: all schemes and formulations, with steps from fine to far too coarse."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.random_scenes.draft import Draft
from tests.random_scenes.draw import rounded
from toolkit.description.run_options import Baumgarte, RunOptions

FINEST, COARSEST = 1 / 300, 1 / 4
"""Steps in parts of the scene's period."""
SHORTEST, LONGEST = 0.8, 3.5
"""Ends in parts of the scene's period."""


def random_options(d: Draft) -> RunOptions:
    """Options that fit together."""
    draw = d.draw
    end = draw.about(SHORTEST * d.period, LONGEST * d.period)
    steps = max(4, round(end / draw.about(FINEST * d.period, COARSEST * d.period)))
    given: dict[str, Any] = {"end_time": end, "step": float(end / steps)}
    given["scheme"] = draw.one(("arnold-bruels",) * 4 + ("paper",))
    chosen, uneven = draw.chance(0.15), draw.chance(0.07)
    if given["scheme"] == "arnold-bruels":
        given["formulation"] = draw.one(("index-1", "index-1", "index-3", "ggl"))
        if chosen:
            given["local_error"] = draw.about(1e-7, 3e-2)
            given["step"] = min(end, max(given["step"], float(0.1 * d.period)))
    if uneven and not chosen:
        given["times"] = _uneven(d, end, steps)
    if d.redundant:
        given["redundant"] = "least-squares"
        if given.get("formulation") == "ggl":
            given["formulation"] = "index-3"
    if d.at_rest and draw.chance(0.25):
        given["quasi_static"] = True
        if given.get("formulation") == "ggl":
            given["formulation"] = "index-1"
    given["rho_inf"] = draw.one((0.0, 0.3, 0.5, 0.5, 0.8, 0.9, 1.0))
    if given.get("formulation") == "index-3":
        given["rho_inf"] = min(given["rho_inf"], 0.5 if chosen or "times" in given else 0.8)
    if draw.chance(0.3):
        given["newton"] = "modified"
    if draw.chance(0.15):
        given["tolerance"] = draw.about(1e-12, 1e-5)
    if draw.chance(0.1):
        rate = draw.about(0.1, 10.0)
        given["baumgarte"] = Baumgarte(damping=rounded(rate / given["step"]), stiffness=rounded(1.4 * rate / given["step"]))
    return RunOptions(**given)


def _uneven(d: Draft, end: float, steps: int) -> tuple[float, ...]:
    """Times of steps whose lengths differ by a few to one."""
    lengths = np.exp(d.draw.generator.uniform(-0.7, 0.7, size=steps))
    inner = np.cumsum(lengths)[:-1] / lengths.sum() * end
    return (0.0, *(rounded(float(time), 8) for time in inner), end)
