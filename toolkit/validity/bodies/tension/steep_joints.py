"""Derivatives of the forces of joints that hold a body at both ends: they feel before the forces what its deflection pulls with.

Beside a force V across, a pull N makes sqrt(V^2 + N^2) larger by N^2 / 2 V^2, and N grows with the square of the deflection. The same is
asked of the states that the derivatives lead to,

    d missing / dx  =  (missing(x + h) - missing(x - h)) / 2 h
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution, check
from toolkit.responses.energy import largest_in
from toolkit.responses.response import Response
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.system.renewal import renewed
from toolkit.system.solution import Solution
from toolkit.validity.bodies.tension.pulled_joints import NAMED, STEEP, Lacking, lacking_joints
from toolkit.validity.bodies.tension.stiffened_bodies import most_pulled

STEP = 1e-3
"""Part of a variable by which it is moved."""
OFF = 0.1
"""Part of a derivative that may be missing without a word, as of other errors of gradients."""
UNIMPORTANT = 0.02
"""A derivative that changes the force by less than this part, where its variable changes by all of itself, is compared with that."""


@check("tension")
def steep_joints(solution: Solution) -> Iterator[Caution]:
    """Derivatives of forces of joints that lack more of themselves than `OFF`, where the solution holds derivatives."""
    low = {name: each for name, each in lacking_joints(solution).items() if abs(each.missing) > STEEP * each.counts > 0}
    off: dict[tuple[str, str], tuple[float, float]] = {}
    for x, variable in enumerate(solution.system.design if low else ()):
        step = STEP * (abs(variable.value) or 1.0)
        try:
            more, less = (lacking_joints(_moved(solution, x, each)) for each in (step, -step))
        except ToolkitError:
            continue
        for name, each in low.items():
            if name in more and name in less:
                missing = (more[name].missing - less[name].missing) / (2 * step)
                slope = _slope(solution, name, each, x)
                if abs(missing) > OFF * max(slope, UNIMPORTANT * each.counts * STEP / step):
                    off[name, variable.name] = missing, abs(missing) / slope if slope else np.inf
    if off:
        worst = sorted(off, key=lambda pair: -off[pair][1])[:NAMED]
        told = ", ".join(f"{f} by {x} by {off[f, x][0]:.3g}{_part(off[f, x][1])}" for f, x in worst)
        yield steep_joints.caution(
            f"the deflection of {most_pulled(solution)} pulls at what holds its ends, which these equations do not know: derivatives of "
            f"the forces there lack what that adds, {told}. Linear FFRF knows this between frames, and not inside of one. Fix: a "
            "model with all nodal coordinates (without [basis]), and frames = 2 or more.",
        )


def _moved(solution: Solution, x: int, step: float) -> Solution:
    """The states that the derivatives lead to, of the scene at the other number."""
    system = solution.system
    variable = tuple(system.design)[x]
    scene, paths = with_numbers(_by_tangents(system.scene), {variable.name: variable.value + step})
    names = ("q", "v", "a", "multipliers")
    states = {name: getattr(solution, name) + step * getattr(solution, f"d{name}")[..., x] for name in names}
    return replace(solution, system=renewed(system, scene, paths), **states)


def _by_tangents(scene: Scene) -> Scene:
    """The scene whose reduced bodies follow the tangent at their own design, where they are known at that alone."""
    bodies = {
        name: body.model_copy(update={"extrapolation": "first-order"}) if isinstance(body, ModelBody) else body
        for name, body in scene.bodies.items()
    }
    return scene.model_copy(update={"bodies": bodies})


def _slope(solution: Solution, name: str, lacking: Lacking, x: int) -> float:
    """The largest derivative in the motion."""
    response = solution.system.scene.responses[name]
    assert isinstance(response, Response)
    return float(largest_in(response, solution, lacking.size).slopes[x])


def _part(part: float) -> str:
    return f" ({part:.0%} of the largest)" if part < 1 else ""
