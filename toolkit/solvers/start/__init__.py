"""Consistent starts: positions that close the joints, velocities that keep them closed, accelerations and multipliers."""
