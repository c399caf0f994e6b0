"""The parts of a reduced model, from finite elements and a basis."""
