"""Base of all joints in the plane; a new joint is one such class with its constraint and the constraint's derivatives by the two poses."""

from __future__ import annotations

from typing import Any, ClassVar

from toolkit.joints.joint import Joint
from toolkit.joints.places import AtPoint


class PlanarJoint(Joint):
    """A constraint g(pose a, pose b, parameters) = f(t) between two bodies in the plane.

    `formula(z, w, phi, phi_z, phi_zz, phi_zww)` (see `joint_kernel`) fills g, g_z, g_zz and d(w^T g_zz w)/dz; if g is linear in the
    poses, `curved` is False and the last two stay zero. `rows` names each row and says whether it is a length or an angle. A time curve
    is subtracted from the last row.

    Attributes
    ----------
    bodies
        Names of bodies a and b; `ground` is always there.
    """

    dimension: ClassVar[int] = 2

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        if cls.kind and hasattr(cls, "formula") and getattr(cls.rows, "__isabstractmethod__", False):
            raise TypeError(
                f'{cls.__name__} has no `rows`: name each row of its constraint and say whether it is a "length" or an "angle", '
                'as a property that returns [("x", "length"), ("rotation", "angle")].'
            )
        super().__pydantic_init_subclass__(**kwargs)


class PointJoint(AtPoint, PlanarJoint):
    """A joint at one point, which belongs to both bodies in the undeformed configuration; or at one point of each."""
