"""The whole mechanism with elements that turn: one chord frame to each, joints in place, against the frames that the scene has.

With one frame through both of its ends every element is the corotational beam element (Crisfield 1991, chapter 7), so that nothing is left
of what floating frames leave out but the elements themselves. Its exact gradients are judged by central differences of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.scene.cut_scene import cuttable, most_frames, written
from toolkit.scene.scene import Scene
from toolkit.sensitivity.compiled import Compiled
from toolkit.sensitivity.direct import evaluated, values_alone
from toolkit.sensitivity.frames.places import largest_displacement, largest_distance, node_places
from toolkit.sensitivity.methods import by_method
from toolkit.sensitivity.numerical import derivative
from toolkit.sensitivity.preparation import Kind, frozen, moving
from toolkit.sensitivity.result import Result
from toolkit.system.solution import Solution

Slopes = dict[str, dict[str, float]]


@dataclass(frozen=True)
class Mechanism:
    """A run beside that with one frame to every element.

    Attributes
    ----------
    elements
        Body -> its elements, each with a frame.
    distances
        Body -> largest distance of a node between both runs, in parts of the body's largest displacement.
    own, corotational
        Values and gradients of both.
    quotients
        Gradients of the second by central differences; without those by variables that nobody can move.
    failure
        Why there is no second run; empty if there is one.
    """

    elements: Mapping[str, int]
    distances: Mapping[str, float] = field(default_factory=dict)
    own: Result | None = None
    corotational: Result | None = None
    quotients: Slopes = field(default_factory=dict)
    failure: str = ""

    def wrong_signs(self) -> list[tuple[str, str]]:
        """Response and variable of the gradients that have the other sign in the mechanism."""
        if self.own is None or self.corotational is None:
            return []
        exact = self.corotational.gradients
        return [(f, x) for f, slopes in self.own.gradients.items() for x, slope in slopes.items() if slope * exact[f][x] < 0]

    def cautions(self) -> list[Caution]:
        """Gradients of the wrong sign; or that nothing is known."""
        if self.failure:
            return [Caution("mechanism", f"with a frame to every element the scene cannot be solved: {self.failure}")]
        pairs = [" by ".join(pair) for pair in self.wrong_signs()]
        if not pairs:
            return []
        return [
            Caution(
                "mechanism",
                f"gradients have the wrong sign: {', '.join(pairs)}. With elements that turn it is the other one. Give the body more "
                "frames.",
            )
        ]


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
    scene = frozen(written(solution.system.scene), solution)
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
    distances = {name: _distance(own.solution, corotational.solution, name) for name in elements}
    return Mechanism(elements, distances, own, corotational, _quotients(other.scene, kind, corotational))


def _distance(own: Solution, corotational: Solution, name: str) -> float:
    size = largest_displacement(corotational, name)
    return largest_distance(node_places(own, name), node_places(corotational, name)) / size if size else 0.0


def _quotients(scene: Scene, kind: Kind, found: Result) -> Slopes:
    slopes: Slopes = {name: {} for name in found.gradients}
    for variable in scene.design_variables(list(next(iter(found.gradients.values()), {}))):
        try:
            for name, value in derivative(scene, variable, kind, "central-difference", found.values).items():
                slopes[name][variable.name] = float(np.real(value))
        except InputError:  # only preprocessing knows what follows from its other values
            continue
    return slopes
