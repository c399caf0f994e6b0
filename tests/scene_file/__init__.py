"""Tests of the room `toolkit.scene_file`."""
