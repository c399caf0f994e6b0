"""Markers in the plane and in space alike: their poses, and the forces on them; which formulas run is known when they are compiled.

Of `plane` and `frames` (`markers.plane`, `markers.frames`) one is None, and numba never compiles what stands behind it.
"""

from toolkit.components.markers.planar import (
    add_force,
    add_force_design,
    add_geometric_stiffness,
    known_turn,
    update_marker_designs,
    update_markers,
    update_places,
)
from toolkit.components.markers.spatial import (
    add_spatial_force,
    add_spatial_force_design,
    add_spatial_stiffness,
    update_spatial_marker_designs,
    update_spatial_markers,
)
from toolkit.foundation.kernel import inlined, inner, kernel
from toolkit.foundation.kinematics.orientation import update_frames


@kernel
def update_poses(plane, frames, markers, state, q, v, acc, linearize, scratch):
    """Evaluate all markers, without their design derivatives; B_v, B_a and b_q only to `linearize`. `scratch` is (3, 3)."""
    if plane is not None:
        update_markers(markers, state, q, v, acc, scratch)
    if frames is not None:
        update_frames(frames, state.frames, q, v, acc)
        update_spatial_markers(markers, state, q, v, acc, linearize)


@inner
def update_positions(plane, frames, markers, state, q, rest):
    """Evaluate the poses of all markers at rest; `rest` is zero."""
    if plane is not None:
        update_places(markers, state, q)
    if frames is not None:
        update_frames(frames, state.frames, q, rest, rest)
        update_spatial_markers(markers, state, q, rest, rest, False)


@inlined
def set_frames(frames, state, q, v, acc):
    """Evaluate the frames alone.

    Where bodies are to feel no rates, the rates given are zero.
    """
    if frames is not None:
        update_frames(frames, state.frames, q, v, acc)


@kernel
def update_pose_designs(plane, frames, markers, state, q, v, acc, scratch):
    """Compute the partial design derivatives of all markers, after `update_poses`."""
    if plane is not None:
        update_marker_designs(markers, state, q, v, acc, scratch)
    if frames is not None:
        update_spatial_marker_designs(markers, state, q, v, acc)


@inlined
def add_pose_force(plane, frames, markers, state, m, force, factor, residual):
    """Add factor * B^T F to the residual, for a force F, as long as a pose, on marker m."""
    if plane is not None:
        add_force(markers, state, m, force, factor, residual)
    if frames is not None:
        add_spatial_force(markers, state, m, force, factor, residual)


@inlined
def add_pose_stiffness(plane, frames, markers, state, m, force, factor, positions, stride, offset, values):
    """Add factor * d(B^T F)/dq at constant F to the values, see `add_geometric_stiffness` and `add_spatial_stiffness`."""
    if plane is not None:
        add_geometric_stiffness(markers, state, m, force, factor, positions, stride, offset, values)
    if frames is not None:
        add_spatial_stiffness(markers, state, m, force, factor, positions, stride, offset, values)


@inlined
def add_pose_force_design(plane, frames, markers, state, m, d, force, factor, residual_x):
    """Add factor * d(B^T F)/dx at constant F to the design derivatives of the residual."""
    if plane is not None:
        c, s = known_turn(markers, state, m)
        add_force_design(markers, state, m, d, force, factor, c, s, residual_x)
    if frames is not None:
        add_spatial_force_design(markers, state, m, d, force, factor, residual_x)
