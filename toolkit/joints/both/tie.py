"""Ties between the parts of a cut body, and between its clamp and the ground: joints that the scene does not show."""

from __future__ import annotations

from toolkit.joints.both.rigid_joint import RigidJoint, SpatialRigidJoint, Welded


class Tie(Welded):
    """Base of rigid joints between two parts of a cut body, or between its clamp and the ground."""

    kind = ""


class PlanarTie(Tie, RigidJoint):
    """A rigid joint in the plane between two parts of a cut body, or between its clamp and the ground."""

    kind = ""


class SpatialTie(Tie, SpatialRigidJoint):
    """A rigid joint in space between two parts of a cut body, or between its clamp and the ground."""

    kind = ""
