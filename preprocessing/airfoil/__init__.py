"""Airfoil files of any common format, their contours as smooth curves by arc length, and the skin's part of them."""
