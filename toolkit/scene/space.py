"""The one record per dimension of space, which holds what scenes in the plane and scenes in space do not share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from toolkit.bodies.body import Body
from toolkit.bodies.planar.body import PlanarBody
from toolkit.bodies.planar.ground import Ground
from toolkit.bodies.spatial.body import SpatialBody
from toolkit.bodies.spatial.ground import SpatialGround
from toolkit.joints.kernels.planar.joint_kernel import ARGUMENTS as JOINT_ARGUMENTS
from toolkit.joints.kernels.planar.joint_kernel import ROWS
from toolkit.joints.kernels.spatial.joint_kernel import ROWS as SPATIAL_ROWS
from toolkit.joints.planar.joint import PlanarJoint
from toolkit.joints.spatial.joint import SpatialJoint
from toolkit.loads.kernels.load_kernel import ARGUMENTS as LOAD_ARGUMENTS
from toolkit.loads.kernels.load_kernel import SPATIAL_ARGUMENTS
from toolkit.loads.planar.load import AnyPlanarLoad
from toolkit.loads.spatial.load import AnySpatialLoad


@dataclass(frozen=True, eq=False)
class Space:
    """What differs between the plane and space; rooms above the scene keep what is theirs in tables by this record.

    Attributes
    ----------
    dimension
        2, or 3.
    axes
        Names of its axes, which name the entries of points and, in space, of every vector.
    kinds
        Group of a scene -> `type` -> class, for all kinds that belong to it; they grow as files define more.
    ground
        The body that is always there.
    joint_rows
        Most rows that a joint can have.
    joint_parameters, load_parameters
        Most parameters that a formula can have; None where joints have rows of forms instead, with numbers as many as they ask for.
    """

    dimension: int
    axes: str
    kinds: Mapping[str, Mapping[str, type]]
    ground: Body
    joint_rows: int
    joint_parameters: int | None
    load_parameters: int


_PLANAR = {"bodies": PlanarBody.kinds, "joints": PlanarJoint.kinds, "loads": AnyPlanarLoad.kinds}
_SPATIAL = {"bodies": SpatialBody.kinds, "joints": SpatialJoint.kinds, "loads": AnySpatialLoad.kinds}
PLANE = Space(2, "xy", _PLANAR, Ground(), ROWS, JOINT_ARGUMENTS - 6, LOAD_ARGUMENTS - 7)
SPACE = Space(3, "xyz", _SPATIAL, SpatialGround(), SPATIAL_ROWS, None, SPATIAL_ARGUMENTS - 25)
SPACES = {space.dimension: space for space in (PLANE, SPACE)}
"""By dimension."""
