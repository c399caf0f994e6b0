"""Bodies whose frame moves, in the plane and in space alike; which formulas run is known when they are compiled, as in `poses`.

`part` holds their invariants; `state` is that of the markers, whose frames in space are those of the bodies.
"""

from toolkit.bodies.kernels.planar.floating_jacobian import floating_jacobian
from toolkit.bodies.kernels.planar.floating_kernel import floating_design, floating_residual
from toolkit.bodies.kernels.spatial.floating_jacobian import spatial_linearized
from toolkit.bodies.kernels.spatial.floating_kernel import spatial_design, spatial_residual
from toolkit.foundation.kernel import inlined


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
