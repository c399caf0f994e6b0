"""All kinds of bodies, joints and loads that a scene file can name, for the plane and for space."""

from __future__ import annotations

from collections.abc import Mapping

import toolkit.bodies.flexible
import toolkit.bodies.ground
import toolkit.bodies.rigid
import toolkit.bodies.spatial.flexible
import toolkit.bodies.spatial.ground
import toolkit.bodies.spatial.rigid
import toolkit.joints.distance
import toolkit.joints.driver
import toolkit.joints.revolute
import toolkit.joints.rigid_joint
import toolkit.joints.slider
import toolkit.joints.spatial.cylindrical
import toolkit.joints.spatial.distance
import toolkit.joints.spatial.driver
import toolkit.joints.spatial.point_on_plane
import toolkit.joints.spatial.prismatic
import toolkit.joints.spatial.revolute
import toolkit.joints.spatial.rigid_joint
import toolkit.joints.spatial.spherical
import toolkit.joints.spatial.universal
import toolkit.loads.point_force
import toolkit.loads.spatial.point_force
import toolkit.loads.spatial.rotational_spring_damper
import toolkit.loads.spatial.spring_damper
import toolkit.loads.spatial.torque
import toolkit.loads.spring_damper
import toolkit.loads.torque  # noqa: F401  (importing a kind is what makes it known)
from toolkit.bodies.body import Body
from toolkit.bodies.spatial.body import SpatialBody
from toolkit.joints.joint import Joint
from toolkit.joints.spatial.joint import SpatialJoint
from toolkit.loads.gravity import Gravity
from toolkit.loads.load import Load
from toolkit.loads.spatial.gravity import SpatialGravity
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.loads.spatial.pressure import Pressure

DIMENSIONS = (2, 3)
"""Of scenes."""


def kinds_of(dimension: int) -> dict[str, Mapping[str, type]]:
    """Group of the scene -> `type` -> class, of the plane (2) or of space (3); kinds of users' own included."""
    if dimension == 3:
        loads = {**SpatialLoad.kinds, SpatialGravity.kind: SpatialGravity, Pressure.kind: Pressure}
        return {"bodies": SpatialBody.kinds, "joints": SpatialJoint.kinds, "loads": loads}
    return {"bodies": Body.kinds, "joints": Joint.kinds, "loads": {**Load.kinds, Gravity.kind: Gravity}}
