"""Bodies that turn so far in a step that what depends on their angle is seen at a few angles only, whatever other steps say."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.bodies.body import Body
from toolkit.bodies.model_body import ModelBody
from toolkit.description.description import InSpace
from toolkit.foundation.verdict import MOTION, Caution, check
from toolkit.loads.bushing import Bushing
from toolkit.scene.scene import Scene
from toolkit.system.marker_states import poses_at
from toolkit.system.solution import Solution

TURN = 2 * np.pi
MOST = 0.35 * TURN
"""Angle in a step: with three steps in a turn nothing is left of a force that turns, and peaks between them are seen (`missed_peaks`)."""
WANTED = 20
"""Steps in a turn that are proposed."""
CENTRED = 1e-9
"""Way of a point as the body turns by 1 rad, in parts of the model size, that is none."""


@check("turns-in-a-step", (MOTION,))
def turns_in_a_step(solution: Solution) -> Iterator[Caution]:
    """A body turns so far in a step that points and forces on it are seen at a few of its angles.

    Limit: 0.35 turns.
    Fix: the `solver.step` that is told: 20 steps in a turn.

    Steps of other lengths may all see it at the same angles: with a turn in each of them a point on a wheel rests, and a force that
    turns with it is constant. The frames of bodies that move freely in space are not looked at: Newton's iteration fails before.
    """
    numbering, scene = solution.system.numbering, solution.system.scene
    turned = {
        name: _furthest(solution, numbering.first[name] + body.moves)
        for name, body in scene.bodies.items()
        if isinstance(body, Body) and body.turns == 1
    }
    far = {name: angle for name, angle in turned.items() if angle > MOST and _matters(solution, name)}
    if far:
        name = max(far, key=lambda each: far[each])
        steps = np.diff(solution.whole_run).max() * TURN / (WANTED * far[name])
        yield turns_in_a_step.caution(
            f"{name!r} turns by up to {far[name] / TURN:.2g} turns in a step (limit {MOST / TURN:g}). Points and forces on it are seen "
            f"at a few of its angles, and other steps may see the same ones. Fix: solver.step = {steps:.1g}, {WANTED} steps in a turn.",
        )


def _furthest(solution: Solution, coordinate: int) -> float:
    """Largest angle in a step; by its rate where not all states are kept."""
    if solution.run_times is not None:
        return float(np.abs(solution.v[:, coordinate]).max() * np.diff(solution.whole_run).max())
    return float(np.abs(np.diff(np.real(solution.q[:, coordinate]))).max(initial=0.0))


def _matters(solution: Solution, name: str) -> bool:
    """Whether anything depends on how the body stands: it deforms, or something grips it or looks at it beside its centre, or along its
    own axes."""
    system, scene = solution.system, solution.system.scene
    body, first = scene.bodies[name], system.numbering.first[name]
    if isinstance(body, ModelBody) or any(_directed(each, name) for each in _components(scene)):
        return True
    own = [m for m, grip in enumerate(system.numbering.markers) if grip[0] == name]
    states = np.real(solution.q[[0, 0]])
    states[1, first + body.moves] += 1.0
    before, after = poses_at(system, states)[:, own, : scene.dimension]
    return bool(np.abs(after - before).max(initial=0.0) > CENTRED * scene.size)


def _components(scene: Scene) -> list[InSpace]:
    return [*scene.joints.values(), *scene.loads.values()]


def _directed(component: InSpace, body: str) -> bool:
    """Whether it acts in directions that turn with the body."""
    held = body in (getattr(component, "body", None), *getattr(component, "bodies", ()))
    own_axes = isinstance(component, Bushing) or getattr(component, "frame", "space") == "body"
    return held and (own_axes or len(getattr(component, "axis", None) or ()) == 2)
