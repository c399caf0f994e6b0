"""Tests of the room `toolkit.compilation`."""
