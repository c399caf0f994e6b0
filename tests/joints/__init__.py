"""Tests of the room `toolkit.components.joints`."""
