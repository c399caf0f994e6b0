"""Tests of the room `toolkit.cost_summary`."""
