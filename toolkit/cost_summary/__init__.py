"""Cost of a scene and its reasons: what its compilation keeps and drops, and what everything put back would cost."""
