"""Tests of the room `toolkit.validity`."""
