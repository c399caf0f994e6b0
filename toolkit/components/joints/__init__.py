"""Joints: constraints between two markers."""
