"""Scenes that turn as a whole about an axis at constant speed: their steady state, and small motions about it."""
