"""The air around a section."""
