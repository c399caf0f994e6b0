"""Tests of the room `toolkit.reduced_model`."""
