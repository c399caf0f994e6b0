"""Tests of the room `toolkit.render`."""
