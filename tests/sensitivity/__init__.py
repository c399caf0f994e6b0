"""Tests of the room `toolkit.analyses.sensitivity`."""
