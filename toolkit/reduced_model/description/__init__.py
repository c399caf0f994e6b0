"""What a flexible body is, in numbers and words: its mass, nodes, elements, named places, and what its mesh file holds besides."""
