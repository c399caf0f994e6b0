"""Tests of the room `toolkit.description`."""
