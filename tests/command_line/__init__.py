"""Tests of the room `toolkit.command_line`."""
