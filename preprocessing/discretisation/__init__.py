"""One body at one design as finite elements: all that precedes the choice of its basis."""
