"""Methods that look for a design by values and derivatives: our own, SciPy's, and NLopt's."""
