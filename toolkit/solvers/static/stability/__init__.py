"""How stable an equilibrium is, and how far from losing its stability."""
