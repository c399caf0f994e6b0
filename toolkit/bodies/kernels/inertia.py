"""Bodies whose frame moves, in the plane and in space alike; which formulas run is known when they are compiled, as in `poses`.

Damping that follows the mass is a force -alpha rho v on every bit of a body, whose virtual work is -dq . alpha M(q) v with the mass matrix
M of the inertial terms. So it is these terms of invariants times alpha, at the velocities in the place of accelerations and in a body whose
velocities are zero; and it does not depend on the frame, as M(q) v does not.

`part` holds their invariants; `state` is that of the markers, whose frames in space are those of the bodies.
"""

from toolkit.bodies.kernels.planar_floating import floating_design, floating_jacobian, floating_residual
from toolkit.bodies.kernels.spatial_floating import spatial_design, spatial_linearized, spatial_residual
from toolkit.foundation.kernel import inlined, inner
from toolkit.markers.poses import set_frames


@inlined
def moving_residual(plane, frames, part, state, q, v, acc, scale, work, inertial, applied):
    """Residual of all bodies whose frame moves."""
    if plane is not None:
        floating_residual(part, q, v, acc, scale, work, inertial, applied)
    if frames is not None:
        spatial_residual(part, state.frames, q, v, acc, scale, work, inertial, applied)


@inlined
def moving_linearized(plane, frames, part, state, q, v, acc, scale, work, inertial, applied, I_acc, I_q, A_q, A_v):
    """The residual and its derivatives by q, v and a."""
    if plane is not None:
        floating_residual(part, q, v, acc, scale, work, inertial, applied)
        floating_jacobian(part, q, v, acc, scale, work, I_acc, I_q, A_q, A_v)
    if frames is not None:
        spatial_linearized(part, frames, state.frames, q, v, acc, scale, work, inertial, applied, I_acc, I_q, A_q, A_v)


@inlined
def moving_design(plane, frames, part, state, q, v, acc, scale, work, I_x, A_x):
    """Partial design derivatives of the residual."""
    if plane is not None:
        floating_design(part, q, v, acc, scale, work, I_x, A_x)
    if frames is not None:
        spatial_design(part, state.frames, q, v, acc, scale, work, I_x, A_x)


@inner
def add_drag(plane, frames, part, state, q, v, rest, linearize, parts, mixed, work, applied, A_q, A_v):
    """applied += alpha M(q) v, and if `linearize` its derivatives; leaves the frames at other rates. `rest` (n,) is zero."""
    set_frames(frames, state, q, rest, v)
    if linearize:
        if frames is not None:  # what M v is multiplied by in the matrix of a step, where all is added to that
            work.mixed[0] = 1 if mixed else 0
            work.mixed[1], work.mixed[2], work.mixed[3], work.mixed[4] = parts[3], parts[2], parts[2], parts[3]
        moving_linearized(plane, frames, part, state, q, rest, v, 0.0, work, applied, applied, A_v, A_q, A_q, A_v)
    else:
        moving_residual(plane, frames, part, state, q, rest, v, 0.0, work, applied, applied)


@inner
def add_drag_design(plane, frames, part, state, q, v, rest, work, A_x):
    """Add the partial design derivatives of the mass-proportional damping force alpha M(q) v to `A_x`."""
    set_frames(frames, state, q, rest, v)
    moving_design(plane, frames, part, state, q, rest, v, 0.0, work, A_x, A_x)
