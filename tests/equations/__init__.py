"""Tests of the room `toolkit.system`."""
