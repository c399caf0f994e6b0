"""Sums of a backward run over many steps, or for all variables together, and the gradient by them; see `design_sums`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import scipy

from toolkit.bodies.kernels.constant_kernel import Changes
from toolkit.compilation.conversions import starts
from toolkit.compilation.patterns.touched import touched
from toolkit.equations.design_sums import DesignSums, GatheredPlan
from toolkit.equations.equations import Plan
from toolkit.joints.kernels.records import DESIGN, DESIGNED, PINNED
from toolkit.markers.planar import Markers


class GatheredDesign(NamedTuple):
    """A plan whose variables change only what is not gathered, and the plan of what is gathered."""

    plan: Plan
    gathered: GatheredPlan
    moves: scipy.sparse.csr_array  # (n_x, 2 n_m + 2 n_columns) derivatives of points and shapes of markers by the variables

    def gradient(self, sums: DesignSums) -> np.ndarray:
        """Gradient (n_x, n_r) that follows from the sums."""
        n_r = sums.points.shape[2]
        return sums.gradient[:, :n_r] + self.moves @ np.concatenate([sums.points, sums.shapes]).reshape(-1, n_r)


def gathered_design(plan: Plan) -> GatheredDesign:
    """Plan of a backward run that gathers changes of matrices, and of points that nothing but pins grip."""
    constant, markers, own = plan.constant, plan.markers, _gripped_by_pins(plan)
    changes = constant.design_mass, constant.design_damping, constant.design_loose
    met = [np.unique(np.concatenate([getattr(each, name) for each in changes])).astype(np.int64) for name in ("row", "column")]
    gathered = GatheredPlan(*changes, *met, *np.nonzero(own[plan.joints.marker]))
    none = Changes(*(np.zeros(size, each.dtype) for size, each in zip((0, 0, 1, 0, 0), changes[0], strict=True)))
    rest: dict[str, Any] = {
        "constant": constant._replace(design_mass=none, design_damping=none, design_loose=none),
        "markers": _without(markers, own) if isinstance(markers, Markers) else markers,
        "joints": plan.joints._replace(of=_designed(plan, own)),
    }
    kept = {name: rest.get(name, getattr(plan, name)) for name in ("floating", "drag", "loads", "pressures", *rest)}
    row, variable = touched(plan.n_x, **kept, curve_index=plan.curve_index, curve_variable=plan.curve_variable)
    return GatheredDesign(plan._replace(**rest, touched_row=row, touched_variable=variable), gathered, _moves(plan, own))


def _gripped_by_pins(plan: Plan) -> np.ndarray:
    """Markers that a variable moves and that nothing grips but pins, whose rows depend on nothing else, (n_m,)."""
    joints, markers = plan.joints, plan.markers
    pins = (joints.of[:, PINNED] == 1) & (joints.of[:, DESIGN] == joints.of[:, DESIGN + 1])
    found: np.ndarray = np.diff(markers.design_start) > 0
    found[np.concatenate([joints.marker[~pins].ravel(), plan.loads.marker.ravel()])] = False
    return found & (plan.markers.plane is not None) & (len(plan.dropped) == 0)


def _designed(plan: Plan, own: np.ndarray) -> np.ndarray:
    """Array `Joints.of`, where pins are left out whose points are gathered."""
    joints, moved = plan.joints, (np.diff(plan.markers.design_start) > 0) & ~own
    of: np.ndarray = joints.of.copy()
    gathered = own[joints.marker].any(axis=1) & ~moved[joints.marker].any(axis=1)
    of[gathered, DESIGNED] = 0
    return of


def _without(markers: Markers, own: np.ndarray) -> Markers:
    """Markers without the design changes of those that are gathered."""
    counts = np.diff(markers.design_start)
    kept = ~np.repeat(own, counts)
    return markers._replace(
        design_start=starts(np.where(own, 0, counts).tolist()),
        design_variable=markers.design_variable[kept],
        design_point=markers.design_point[kept],
        design_shape_start=markers.design_shape_start[kept],
    )


def _moves(plan: Plan, own: np.ndarray) -> scipy.sparse.csr_array:
    """Matrix `GatheredDesign.moves` of the markers that are gathered."""
    markers, counts = plan.markers, np.diff(plan.markers.design_start)
    d = np.flatnonzero(np.repeat(own, counts))
    m, sizes = np.repeat(np.arange(len(own)), counts)[d], np.diff(markers.start)
    before = np.cumsum(sizes[m]) - sizes[m]
    within = np.arange(sizes[m].sum()) - np.repeat(before, sizes[m])
    row, column = (np.repeat(first, sizes[m]) + within for first in (markers.design_shape_start[d], markers.start[m]))
    variable = markers.design_variable[d]
    value = np.concatenate([markers.design_point[d, :2], markers.design_shape[row, :2]])
    place = 2 * np.concatenate([m, len(own) + column])[:, None] + np.arange(2)
    of = np.repeat(np.concatenate([variable, np.repeat(variable, sizes[m])]), 2)
    return scipy.sparse.csr_array(
        (value.ravel(), (of, place.ravel())), shape=(plan.n_x, 2 * (len(own) + len(markers.coordinate)))
    )
