"""What the numbers of a reduced model make one ask: materials that nobody has, meshes that are too coarse."""
