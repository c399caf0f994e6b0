"""Tests of the room `toolkit.files`."""
