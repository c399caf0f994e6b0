"""Loads: forces and torques between two markers, weight, and pressure; one kind per file, in the plane and in space."""
