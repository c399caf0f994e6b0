"""Orientation in the plane and in space, and the functions along a beam; no body, no scene."""
