"""Tests of the room `toolkit.linear`."""
