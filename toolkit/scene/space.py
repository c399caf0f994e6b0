"""The one record per dimension of space, which holds what scenes in the plane and scenes in space do not share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from toolkit.components.bodies.body import Body, PlanarBody, SpatialBody
from toolkit.components.bodies.cut_body import CutBody, PlanarCutBody, SpatialCutBody
from toolkit.components.bodies.ground import Ground, SpatialGround
from toolkit.components.joints.joint import PlanarJoint, SpatialJoint
from toolkit.components.joints.kernels.records import ROWS, SPATIAL_ROWS
from toolkit.components.joints.rigid_joint import PlanarTie, SpatialTie, Tie
from toolkit.components.loads.kernels.load_kernel import ARGUMENTS as LOAD_ARGUMENTS
from toolkit.components.loads.kernels.load_kernel import SPATIAL_ARGUMENTS
from toolkit.components.loads.load import AnyPlanarLoad, AnySpatialLoad
from toolkit.description.description import Registered


@dataclass(frozen=True, eq=False)
class Space:
    """Record of the differences between the plane and space; rooms above the scene keep what is theirs in tables by this record.

    Attributes
    ----------
    dimension
        2, or 3.
    axes
        Names of its axes, which name the entries of points and, in space, of every vector.
    kinds
        Group of a scene -> `type` -> class, for all kinds that belong to it; they grow as files define more.
    named_vectors
        Whether the names of the axes name the entries of every vector, and not of points alone.
    ground
        The body that is always there.
    cut_body, tie
        A body that is cut into parts, and the joint between two of them.
    frame_size
        Coordinates of a frame that moves and turns.
    constant_rigid_mass
        Whether a rigid body's mass matrix is constant however it turns, its frame being at its centre of mass.
    rotations_add
        Whether a rotation is one angle, of any number of turns; else it is about an axis that has to be said, and known to half a turn.
    turning_elements
        Whether the preprocessing has finite elements that turn, which a flexible body can be compared with.
    camera
        Whether its pictures are what a camera sees, in pixels; else they are lines and may be vectors.
    wrench
        Components of the force and torque of a joint.
    joint_rows
        Most rows that a joint can have.
    load_parameters
        Most parameters that the formula of a load can have.
    """

    dimension: int
    axes: str
    named_vectors: bool
    kinds: Mapping[str, Mapping[str, type[Registered]]]
    ground: Body
    cut_body: type[CutBody]
    tie: type[Tie]
    frame_size: int
    constant_rigid_mass: bool
    rotations_add: bool
    turning_elements: bool
    camera: bool
    wrench: tuple[str, ...]
    joint_rows: int
    load_parameters: int


PLANE = Space(
    dimension=2,
    axes="xy",
    named_vectors=False,
    kinds={"bodies": PlanarBody.kinds, "joints": PlanarJoint.kinds, "loads": AnyPlanarLoad.kinds},
    ground=Ground(),
    cut_body=PlanarCutBody,
    tie=PlanarTie,
    frame_size=3,
    constant_rigid_mass=True,
    rotations_add=True,
    turning_elements=True,
    camera=False,
    wrench=("x", "y", "torque"),
    joint_rows=ROWS,
    load_parameters=LOAD_ARGUMENTS - 7,
)
SPACE = Space(
    dimension=3,
    axes="xyz",
    named_vectors=True,
    kinds={"bodies": SpatialBody.kinds, "joints": SpatialJoint.kinds, "loads": AnySpatialLoad.kinds},
    ground=SpatialGround(),
    cut_body=SpatialCutBody,
    tie=SpatialTie,
    frame_size=7,
    constant_rigid_mass=False,
    rotations_add=False,
    turning_elements=False,
    camera=True,
    wrench=("x", "y", "z", "torque-x", "torque-y", "torque-z"),
    joint_rows=SPATIAL_ROWS,
    load_parameters=SPATIAL_ARGUMENTS - 25,
)
SPACES = {space.dimension: space for space in (PLANE, SPACE)}
"""Records of the plane and of space, by dimension."""
