"""Tests of the room `toolkit.foundation`."""
