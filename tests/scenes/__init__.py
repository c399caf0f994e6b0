"""Whole scenes against published values and closed forms."""
