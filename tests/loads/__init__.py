"""Tests of the room `toolkit.loads`."""
