"""Tests of the room `toolkit.joints`."""
