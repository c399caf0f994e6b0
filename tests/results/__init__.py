"""Tests of the room `toolkit.results`."""
