"""Tests of the room `toolkit.scene`."""
