"""Parts of a body between two of its nodes, assembled from its elements."""
