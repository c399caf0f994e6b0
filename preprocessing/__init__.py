"""From an airfoil file to the reduced model of its flexible skin."""
