"""A planar scene in space: the same bodies in the plane z = 0, each with the coordinates x, y and a quaternion of its own.

Joints are those of the plane, with as few rows out of it as keep every body in it: no row is redundant. Every body is held in the
plane by one point on the plane and no rotation about x and y: see `held`.
"""

from __future__ import annotations
