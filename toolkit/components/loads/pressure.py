"""Pressure on a named surface of a flexible body."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from toolkit.components.bodies.body import Placed
from toolkit.components.bodies.flexible import SpatialFlexible
from toolkit.components.curves.catalogue import Curve
from toolkit.components.curves.polynomial import Constant
from toolkit.components.loads.load import AnySpatialLoad
from toolkit.description.description import Number, Quantity
from toolkit.foundation.errors import InputError, listed, meant


class PressureNumbers(NamedTuple):
    """f (3,) and L (1 + n_f, 9) of `SurfaceLoad` times the pressure, in the axes of the body's frame at the start."""

    force: np.ndarray
    moment: np.ndarray


class Pressure(AnySpatialLoad):
    """Pressure p s(t) on a surface that the body's reduced model names; it follows the body's frame, not the deformation: on a solid in
    pieces with several frames each of these.

    Attributes
    ----------
    body
        Flexible body that the pressure acts on.
    surface
        Name of the surface, one of `pressure_surfaces` in the file that the reduced model was built from.
    pressure
        p, in force/length^2; positive pushes on the surface.
    curve
        s(t).
    """

    kind = "pressure"
    proportional = ("pressure",)

    body: str
    surface: str
    pressure: Annotated[Number, Quantity("stress")]
    curve: Annotated[Curve, Quantity("none")] = Constant()

    def numbers_on(self, scene: Placed, body: SpatialFlexible) -> PressureNumbers:
        """Numbers that the equations need of the pressure on its body, or on a part of that.

        Raises
        ------
        InputError
            The body's reduced model has no such surface; lists those that it has.
        """
        model = scene.model(body.model, "surface_loads")
        known = model.surface_loads or {}
        if self.surface not in known:
            raise InputError(
                f"reduced model {model.label} has no surface {self.surface!r} to press on{meant(self.surface, known)}; it has: "
                f"{listed(known)}. Name it in [pressure_surfaces] of the file that the model is built from, and run preprocessing again."
            )
        load, A = body.surface_load(scene, self.surface), np.eye(3) if body.frame == "moving" else body.placement
        turned = np.einsum("ac,bd,cdj->jab", A, A, load.moment)
        return PressureNumbers(self.pressure * (A @ load.force), self.pressure * turned.reshape(len(turned), 9))
