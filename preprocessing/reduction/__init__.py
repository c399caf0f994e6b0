"""From finite elements to the parts of a reduced model: bodies at one design, bases, invariants and their derivatives."""
