"""The whole mechanism with elements that turn: one chord frame to each, joints in place, against the frames that the scene has.

With one frame through both of its ends every element is the corotational beam element (Crisfield 1991, chapter 7), so that nothing is left
of what floating frames leave out but the elements themselves. Its exact gradients are judged by central differences of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.direct import derivative, evaluated, values_alone
from toolkit.analyses.sensitivity.methods import by_method
from toolkit.analyses.sensitivity.preparation import Kind, frozen, moving
from toolkit.analyses.sensitivity.run import Run
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.scene.resolution import cuttable, most_frames
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution
from toolkit.validity.bodies.deformation import LIMIT, has_places, is_moving, largest_displacement, node_places, relative_distance

Slopes = dict[str, dict[str, float]]
DIFFERENCE_ROUND_OFF = 1e-6
"""Part of the largest value of its quantity that a difference has to be, not to be taken for round-off."""


@dataclass(frozen=True)
class Mechanism:
    """A run beside that with one frame to every element.

    Attributes
    ----------
    elements
        Body -> its elements, each with a frame.
    distances
        Body -> largest distance of a node between both runs, in parts of the body's largest displacement; without bodies in one frame on a
        chord in space, whose nodes nobody has kept.
    own, corotational
        Values and gradients of both.
    quotients
        Gradients of the second by central differences; without those by variables that nobody can move.
    failure
        Why there is no second run; empty if there is one.
    """

    elements: Mapping[str, int]
    distances: Mapping[str, float] = field(default_factory=dict)
    own: Run | None = None
    corotational: Run | None = None
    quotients: Slopes = field(default_factory=dict)
    failure: str = ""

    def wrong_signs(self) -> list[tuple[str, str]]:
        """Response and variable of the gradients that have the other sign in the mechanism, or are zero in one of both alone."""
        if self.own is None or self.corotational is None:
            return []
        exact = self.corotational.gradients
        return [(f, x) for f, slopes in self.own.gradients.items() for x, slope in slopes.items() if _differ(slope, exact[f][x])]

    def far_values(self) -> dict[str, float]:
        """Response -> by what part of it the run is off, of those that are off by more than `LIMIT`, not counting what is round-off
        beside others of its quantity."""
        if self.own is None or self.corotational is None:
            return {}
        responses, exact, found = self.corotational.solution.system.scene.responses, self.corotational.values, {}
        kinds = {name: getattr(response, "unit_quantity", "") for name, response in responses.items()}
        for name, value in self.own.values.items():
            alike = [abs(exact[f]) for f in exact if kinds[f] == kinds[name]]
            off = abs(value - exact[name])
            if off > LIMIT * abs(exact[name]) and off > DIFFERENCE_ROUND_OFF * max(alike):
                found[name] = off / abs(exact[name]) if exact[name] else np.inf
        return found

    def cautions(self) -> list[Caution]:
        """Nodes, values or gradients that are far off; or that nothing is known."""
        if self.failure:
            return [Caution("mechanism", f"with a frame to every element the scene cannot be solved: {self.failure}")]
        found = [
            f"nodes of {name} are off by {part:.1%} of its displacement" for name, part in self.distances.items() if part > LIMIT
        ]
        if values := self.far_values():
            found.append("values are off: " + ", ".join(f"{name} by {off:.0%}" for name, off in values.items()))
        if pairs := [" by ".join(pair) for pair in self.wrong_signs()]:
            found.append(f"gradients have the wrong sign, or are zero where they are not: {', '.join(pairs)}")
        doubt = Caution("mechanism", f"{'; '.join(found)}. So says a frame to every element; give the body more frames.")
        return [doubt, *self._same()] if found else self._same()

    def _same(self) -> list[Caution]:
        """Bodies that have a frame to every element already, which says nothing of these."""
        bodies = {} if self.own is None else self.own.solution.system.scene.bodies
        alike = [
            name for name, most in self.elements.items() if most > 1 and len(getattr(bodies.get(name), "cuts", ())) == most + 1
        ]
        if not alike:
            return []
        text = (
            f"{', '.join(alike)}: every element has a frame of its own in the run already, so that nothing is compared. How exact the "
            "elements are, a model with more of them tells."
        )
        return [Caution("compared-with-itself", text, doubt=False)]


def _differ(slope: float, exact: float) -> bool:
    """Whether two derivatives differ in their signs, or one alone is zero."""
    return slope * exact < 0 or (slope == 0) != (exact == 0)


def compare_mechanism(solution: Solution, names: Sequence[str]) -> Mechanism | None:
    """Solve the scene of a run again with one frame to every element; None if none of its bodies can have that.

    Parameters
    ----------
    solution
        The run.
    names
        Design variables whose gradients are compared.
    """
    kind: Kind = "transient" if moving(solution) else "static"
    scene = frozen(solution.system.scene.written, solution)
    elements = {name: most_frames(scene, name) for name in cuttable(scene)}
    if not elements:
        return None
    compiled = Compiled(scene, tuple(names))
    try:
        other = compiled.reframed(elements)
        corotational = by_method("auto", other, kind) if names else values_alone(other, kind)
    except ToolkitError as error:
        return Mechanism(elements, failure=str(error))
    own = by_method("auto", compiled, kind) if names else evaluated(solution, False)
    known = [name for name in elements if has_places(own.solution.system.scene, name)]
    distances = {name: _distance(own.solution, corotational.solution, name) for name in known}
    return Mechanism(elements, distances, own, corotational, _quotients(other.scene, kind, corotational))


def _distance(own: Solution, corotational: Solution, name: str) -> float:
    size, moves = largest_displacement(corotational, name), is_moving(own.system.scene, name)
    return relative_distance(node_places(own, name), node_places(corotational, name), size, moves)


def _quotients(scene: Scene, kind: Kind, found: Run) -> Slopes:
    slopes: Slopes = {name: {} for name in found.gradients}
    for variable in scene.design_variables(list(next(iter(found.gradients.values()), {}))):
        try:
            for name, value in derivative(scene, variable, kind, "central-difference", found.values).items():
                slopes[name][variable.name] = float(np.real(value))
        except InputError:  # only preprocessing knows what follows from its other values
            continue
    return slopes
