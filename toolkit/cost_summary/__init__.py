"""What a scene costs and why: what its compilation keeps and drops, and what everything put back would cost."""
