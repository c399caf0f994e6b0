"""What ties the parts of a cut body to each other, and its clamp to the ground: joints that the scene does not show."""

from __future__ import annotations

from toolkit.joints.both.rigid_joint import RigidJoint, SpatialRigidJoint, Welded


class Tie(Welded):
    """Between two parts of a body, or between its clamp and the ground."""

    kind = ""


class PlanarTie(Tie, RigidJoint):
    """In the plane."""

    kind = ""


class SpatialTie(Tie, SpatialRigidJoint):
    """In space."""

    kind = ""
