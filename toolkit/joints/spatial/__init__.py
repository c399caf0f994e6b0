"""Joints in space: quadratic forms of the poses of two markers."""
