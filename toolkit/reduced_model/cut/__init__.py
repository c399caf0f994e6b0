"""Parts of a planar body between two of its nodes, assembled from its elements."""
