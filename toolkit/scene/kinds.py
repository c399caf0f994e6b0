"""All kinds of bodies, joints and loads that a scene file can name, for the plane and for space."""

from __future__ import annotations

from collections.abc import Mapping

from toolkit.bodies.body import Body
from toolkit.bodies.spatial.body import SpatialBody
from toolkit.description.registration import import_room
from toolkit.joints.planar.joint import Joint
from toolkit.joints.spatial.joint import SpatialJoint
from toolkit.loads.planar.gravity import Gravity
from toolkit.loads.planar.load import Load
from toolkit.loads.spatial.gravity import SpatialGravity
from toolkit.loads.spatial.load import SpatialLoad
from toolkit.loads.spatial.pressure import Pressure

DIMENSIONS = (2, 3)
"""Of scenes."""

for _room in ("bodies", "joints", "loads"):
    for _space in ("planar", "spatial"):
        import_room(f"toolkit.{_room}.{_space}")


def kinds_of(dimension: int) -> dict[str, Mapping[str, type]]:
    """Group of the scene -> `type` -> class, of the plane (2) or of space (3); kinds of users' own included."""
    if dimension == 3:
        loads = {**SpatialLoad.kinds, SpatialGravity.kind: SpatialGravity, Pressure.kind: Pressure}
        return {"bodies": SpatialBody.kinds, "joints": SpatialJoint.kinds, "loads": loads}
    return {"bodies": Body.kinds, "joints": Joint.kinds, "loads": {**Load.kinds, Gravity.kind: Gravity}}
