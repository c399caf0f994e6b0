"""Tests of the room `toolkit.responses`."""
