"""Tests of the room `toolkit.sensitivity`."""
