"""Tests of the room `toolkit.components.loads`."""
