"""Tests of the room `toolkit.studies`."""
