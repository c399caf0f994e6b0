"""How the nodes of elements are numbered in mesh files: repeated nodes, nodes between corners, elements twice."""
