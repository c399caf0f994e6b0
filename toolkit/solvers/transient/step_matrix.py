"""The matrix of a time step: from derivatives by q, v and [a; lam], or filled by these at once."""

from toolkit.foundation.kernel import inlined
from toolkit.solvers.transient.scheme import by_acceleration


@inlined
def newton_matrix(plan, scheme, terms, apart, jacobian, rest):
    """Compute d residual / d [a; lam] at n + 1: w_I (I_acc + c_q I_q) + w_A (c_q A_q + c_v A_v).

    Without inertia I_acc counts for lam alone.

    With the terms `apart` from the factored stiffness, `rest` is the same without that; otherwise it is not touched.
    """
    c_q, c_v = by_acceleration(scheme)
    w_i, w_a = scheme.weight_inertial, scheme.weight_applied
    I_acc, I_q, A_q, A_v = terms.I_acc, terms.I_q, terms.A_q, terms.A_v  # looked up once, or nothing is done several at a time
    for e in range(len(jacobian)):
        jacobian[e] = w_i * (I_acc[e] + c_q * I_q[e]) + w_a * (c_q * A_q[e] + c_v * A_v[e])
    if not scheme.inertia:
        for e in range(len(jacobian)):
            if plan.indices[e] < plan.n_q:
                jacobian[e] -= w_i * terms.I_acc[e]
    if apart == 1:
        by_strain, strained = w_a * c_q, plan.constant.strained
        for e in range(len(jacobian)):
            rest[e] = jacobian[e]
            jacobian[e] += by_strain * strained[e]


@inlined
def mix(frames, plan, scheme, ggl, memory):
    """Target of the derivatives: in space the step's matrix itself, unless gradients or other formulations need their parts.

    One matrix in the place of four, which are added up otherwise, is a third of what a step of many bodies reads and writes.
    """
    if frames is not None:
        (c_q, c_v), mixed = by_acceleration(scheme), memory.work.floating.mixed
        w_i, w_a = scheme.weight_inertial, scheme.weight_applied
        if plan.n_x == 0 and not ggl.active and scheme.inertia:
            mixed[0], mixed[1], mixed[2], mixed[3], mixed[4] = 1, w_i, w_i * c_q, w_a * c_q, w_a * c_v
            return memory.whole
        mixed[0], mixed[1], mixed[2], mixed[3], mixed[4] = 0, 1, 1, 1, 1
    return memory.terms
