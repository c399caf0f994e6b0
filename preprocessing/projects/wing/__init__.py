"""A morphing wing of one's own from any airfoil file."""
