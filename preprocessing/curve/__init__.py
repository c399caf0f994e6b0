"""Smooth plane curves by their arc length: contours, their bumps, and the skin's part of them."""
