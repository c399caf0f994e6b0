"""Tests of the room `toolkit.equations`."""
