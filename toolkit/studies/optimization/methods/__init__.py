"""Methods that look for a design by values and derivatives: SciPy's, and NLopt's."""
