"""Tests of the room `toolkit.report`."""
