"""Tests of the room `toolkit.receipt`."""
