"""Responses over time: integrals, means, extremes of what another response is at each time."""
