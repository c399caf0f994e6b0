"""How exactly a motion was integrated, and whether its steps saw all that acts."""
