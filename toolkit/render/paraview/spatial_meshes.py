"""What a time series for ParaView holds of a scene in space: surfaces with displacement and stress, and the mechanism."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from toolkit.foundation.units import unit
from toolkit.render.paraview.mechanism_lines import mechanism
from toolkit.render.paraview.solid_stress import add_stress
from toolkit.render.space import parts
from toolkit.render.space.body_shape import at_points, body_shape, has_shape
from toolkit.render.space.configuration import SpatialConfiguration
from toolkit.responses.stress.stress import stress_field
from toolkit.system.flexible_bodies import flexible_body
from toolkit.system.solution import Solution


def spatial_meshes(solution: Solution) -> Callable[[int], dict[str, Any]]:
    """Step -> meshes by name.

    Every flexible body with a surface is that surface, with the lines of beams, and has as point data "displacement in <unit>" from the
    undeformed configuration; of a solid "von Mises stress in <unit>" and "stress in <unit>", six components in the body's own axes; of
    beams "stress in <unit>" of the fibre; and where the run has derivatives, "<the one stress> by <variable>".
    """
    scene, start = solution.system.scene, SpatialConfiguration.undeformed(solution)
    bodies = {body: body_shape(start, body).points for body in start.flexible() if has_shape(scene, body)}
    design = solution.system.design.names
    rates = {body: stress_field(solution, body)[1] for body in bodies} if design and solution.dq.shape[-1] else {}

    def at(step: int) -> dict[str, Any]:
        moment = SpatialConfiguration(solution, step)
        found = {body: _surface(moment, body, points) for body, points in bodies.items()}
        for body, by in rates.items():
            surface = scene.model(flexible_body(scene, body).model, "surface").surface
            assert surface is not None
            for x, variable in enumerate(design):
                found[body].point_data[f"{_name(found[body])} by {variable}"] = at_points(surface, by[step, :, x])
        return found | {"mechanism": mechanism(moment)}

    return at


def _name(mesh: Any) -> str:
    return "von Mises stress" if any(name.startswith("von Mises") for name in mesh.point_data) else "stress"


def _surface(moment: SpatialConfiguration, body: str, undeformed: np.ndarray) -> Any:
    shape, units = body_shape(moment, body), moment.scene.units
    mesh, label = parts.whole(shape), f"stress in {unit(units, 'stress')}"
    mesh.point_data[f"displacement in {unit(units, 'length')}"] = shape.points - undeformed
    if shape.stress.shape[1] == 1:
        mesh.point_data[label] = shape.stress[:, 0]
    else:
        add_stress(mesh, shape.stress, label)
    return mesh
