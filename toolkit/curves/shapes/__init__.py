"""Formulas that several kinds of curves share, or that are long."""
