"""All joints of a scene, in the plane and in space alike; which formulas run is known when they are compiled, as in `markers.poses`.

In space the lengths of quaternions are constraints too.
"""

from toolkit.components.joints.kernels.planar_joint import evaluate_planar_joint, joint_design, joint_jacobian, joint_residual
from toolkit.components.joints.kernels.planar_pin import add_pin, pin_design, pin_jacobian
from toolkit.components.joints.kernels.records import DESIGN, DESIGNED, PINNED
from toolkit.components.joints.kernels.spatial_joint import (
    evaluate_spatial_joint,
    spatial_joint_design,
    spatial_joint_jacobian,
    spatial_joint_residual,
)
from toolkit.foundation.kernel import inlined, inner
from toolkit.foundation.kinematics.orientation import lengths_jacobian, lengths_residual


@inlined
def evaluate_any_joint(plane, frames, functions, joints, j, markers, state, acc, work):
    """Compute the rows of one joint, their derivatives, and its force g_z^T lam."""
    if plane is not None:
        evaluate_planar_joint(functions, joints, j, state, acc, work)
    if frames is not None:
        evaluate_spatial_joint(functions, joints, j, state, acc, work)


@inlined
def add_joints(plane, frames, functions, joints, markers, state, inputs, q, v, acc, linearize, work, parts, terms):
    """Add the rows and forces of all joints to both groups of the residual, and if `linearize` their derivatives by the state.

    A joint in the plane that makes two points coincide, as a revolute does, takes the formulas of pins (`planar_pin`).
    """
    if plane is not None:
        for j in range(len(joints.of)):
            if joints.of[j, PINNED]:
                add_pin(joints, j, markers, state, acc, inputs.levels, terms.inertial, terms.applied)
                if linearize:
                    pin_jacobian(
                        joints, j, markers, state, acc, inputs.levels, work, terms.I_acc, terms.I_q, terms.A_q, terms.A_v
                    )
                continue
            add_planar_joint(
                functions, joints, j, markers, state, inputs, acc, linearize, work, terms.inertial, terms.applied,
                terms.I_acc, terms.I_q, terms.A_q, terms.A_v,
            )  # fmt: skip
    if frames is not None:
        lengths_residual(frames, q, v, acc, inputs.levels, terms.inertial, terms.applied)
        if linearize:
            lengths_jacobian(frames, q, v, acc, inputs.levels, parts, terms.I_acc, terms.I_q, terms.A_q, terms.A_v)
        for j in range(len(joints.of)):
            evaluate_spatial_joint(functions, joints, j, state, acc, work)
            spatial_joint_residual(joints, j, markers, state, inputs.curves, inputs.levels, work, terms.inertial, terms.applied)
            if linearize:
                spatial_joint_jacobian(
                    joints, j, markers, state, inputs.levels, acc, work, parts, terms.I_acc, terms.I_q, terms.A_q, terms.A_v
                )


@inner
def add_planar_joint(
    functions, joints, j, markers, state, inputs, acc, linearize, work, inertial, applied, I_acc, I_q, A_q, A_v
):  # fmt: skip
    """Add any joint in the plane; a function of its own, as most are pins."""
    evaluate_planar_joint(functions, joints, j, state, acc, work)
    joint_residual(joints, j, markers, state, inputs.curves, inputs.levels, work, inertial, applied)
    if linearize:
        joint_jacobian(joints, j, markers, state, inputs.levels, work, I_acc, I_q, A_q, A_v)


@inlined
def add_joint_designs(plane, frames, functions, joints, markers, state, inputs, acc, curve_variable, curve_index, work, terms):
    """Add the partial derivatives of all rows and forces by the design."""
    designed = 0
    for j in range(len(joints.of)):
        designed += joints.of[j, DESIGNED]
    if designed and plane is not None:
        add_planar_designs(
            functions, joints, markers, state, inputs, acc, curve_variable, curve_index, work, terms.I_x, terms.A_x
        )
    if designed and frames is not None:
        add_spatial_designs(
            functions, joints, markers, state, inputs, acc, curve_variable, curve_index, work, terms.I_x, terms.A_x
        )


@inner
def add_planar_designs(functions, joints, markers, state, inputs, acc, curve_variable, curve_index, work, I_x, A_x):
    """Add the partial design derivatives of all joints in the plane.

    This is a function of its own, so that the code of every evaluation stays short.
    """
    for j in range(len(joints.of)):
        if joints.of[j, DESIGNED] and joints.of[j, PINNED] and joints.of[j, DESIGN] == joints.of[j, DESIGN + 1]:
            pin_design(joints, j, markers, state, acc, inputs.levels, work, I_x, A_x)
        elif joints.of[j, DESIGNED]:
            evaluate_planar_joint(functions, joints, j, state, acc, work)
            joint_design(
                joints, j, markers, state, acc, curve_variable, curve_index, inputs.curves_x, inputs.levels, work, I_x, A_x
            )


@inner
def add_spatial_designs(functions, joints, markers, state, inputs, acc, curve_variable, curve_index, work, I_x, A_x):
    """Add the partial design derivatives of all joints in space."""
    for j in range(len(joints.of)):
        if joints.of[j, DESIGNED]:
            evaluate_spatial_joint(functions, joints, j, state, acc, work)
            spatial_joint_design(
                joints, j, markers, state, acc, curve_variable, curve_index, inputs.curves_x, inputs.levels, work, I_x, A_x
            )
