"""Flexible bodies from a finite-element mesh of any program, or from finished matrices."""
