"""Beam elements that turn with the body: the judge of small deformations."""
