"""Bases of bodies with many nodes: factors, modes and static shapes of large sparse matrices."""
