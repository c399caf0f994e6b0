"""How far a point of a flexible body has moved in the body's own frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.compilation.dependence import items_of
from toolkit.compilation.quantities import STEP
from toolkit.foundation.errors import InputError
from toolkit.responses.instant import Instant
from toolkit.responses.kinematics.marker_formula import one_of, place_of, refuse_component
from toolkit.responses.response import Partials
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.flexible_bodies import elastic_coordinates, flexible_body
from toolkit.system.solution import Solution


class Deflection(Instant):
    """Displacement of a point of a flexible body by its deformation alone, in the axes of the body's own frame: u = Z q_f.

    What it is measured from is the body's reference condition, which `ffrf inspect` names: a clamp, mean axes or a chord.

    Attributes
    ----------
    body
        Name of a flexible body.
    point
        Name of an interface point on it.
    component
        One component in the axes of the body's reduced model, or the magnitude.
    """

    kind = "deflection"
    quantity = "length"

    body: str
    point: str
    component: Literal["x", "y", "z", "magnitude"] = "magnitude"

    def check(self, scene: Any) -> None:
        """Refuse a body that is rigid or has several frames, a point that is none of it, and a z component in the plane."""
        super().check(scene)
        refuse_component(self.component, scene, self.kind)
        found = flexible_body(scene, self.body)
        if found.parted:
            raise InputError(
                f"the deflection of body {self.body!r} is that in its own frame, and it has several: no frame is that of the whole body. "
                'Ask for the displacement of the point (type = "displacement"), or leave `frames` out.'
            )
        found.point(scene, self.point, self.body)

    def at(self, solution: Solution, step: int) -> Partials:
        """Component or magnitude of Z q_f at a step, with its partial derivatives."""
        return self.instants(solution)(step)

    def instants(self, solution: Solution) -> Callable[[int], Partials]:
        """Component or magnitude of Z q_f, step by step; Z and its design derivatives are found once for all steps."""
        system, where = solution.system, elastic_coordinates(solution, self.body)
        shape, shape_x = self._shape(system.scene), list[tuple[int, np.ndarray]]()
        for x, variable in enumerate(system.design):
            affected = items_of(system.scene, variable.paths, system.numbering.users)
            if not affected.isdisjoint({("bodies", self.body), ("points", self.point)}):
                moved = self._shape(system.scene.moved(variable, 1j * STEP))
                shape_x.append((x, np.imag(moved) / STEP))

        def look(step: int) -> Partials:
            q_f = solution.q[step, where]
            slope: np.ndarray = np.zeros((len(shape), system.n_q), system.dtype)
            slope[:, where] = shape
            design = np.zeros((len(shape), system.n_x))
            for x, change in shape_x:
                design[:, x] = change @ np.real(q_f)
            return one_of(Partials(shape @ q_f, q=slope, design=design), place_of(self.component), solution, step)

        return look

    def _shape(self, scene: ResolvedScene) -> np.ndarray:
        body = scene.bodies[self.body]
        assert isinstance(body, ModelBody)
        return body.point(scene, self.point, self.body)[0][:, 1:]
