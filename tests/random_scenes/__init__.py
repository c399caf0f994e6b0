"""Random scenes of all kinds, the same for the same seed on every machine: what a verdict is judged by."""

from tests.random_scenes.scene import random_scene

__all__ = ["random_scene"]
