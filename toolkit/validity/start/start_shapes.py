"""What became of the deflections that a scene writes for the start."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import elastic_coordinates
from toolkit.system.solution import Solution

MOVED = 1e-9
"""Move of a body, a part of the scene's size or in rad, below which its position is as good as written with nine digits."""


def _written_shapes(scene: Scene) -> dict[str, ModelBody]:
    """Flexible bodies whose deflection at the start is written."""
    return {name: body for name, body in scene.bodies.items() if isinstance(body, ModelBody) and body.deflected["deflection"]}


def bent_otherwise(solution: Solution) -> Iterator[Caution]:
    """Where closing the joints has changed a deflection that is written."""
    scene = solution.system.placed
    for name, body in _written_shapes(scene).items():
        q_f = np.real(solution.q[0, elastic_coordinates(solution, name)])
        for point, written in body.deflected["deflection"].items():
            found = np.real(body.point(scene, point, name)[0][:, 1:]) @ q_f
            if np.abs(found - np.real(written)).max() > MOVED * scene.size:
                length = unit(scene.units, "length")
                used, wish = (", ".join(f"{x:.6g}" for x in np.real(each)) for each in (found, written))
                yield Caution(
                    "assembled",
                    f"solver.assemble bent {name!r} before the start, so that the joints close: its deflection at point {point!r} is "
                    f"[{used}] {length} instead of the written [{wish}] {length}.",
                    doubt=False,
                )


def shapes_without_effect(solution: Solution) -> Iterator[Caution]:
    """Of a state of rest: it has no use for a deflection at the start."""
    for name in [*_written_shapes(solution.system.placed)][:1]:
        yield Caution(
            "deflection-without-effect",
            f"the deflection of {name!r} at the start has no effect: an equilibrium, and a run that starts from one, finds its own shape.",
            doubt=False,
        )
