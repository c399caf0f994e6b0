"""Equations of motion of bodies in the compiled loop."""
