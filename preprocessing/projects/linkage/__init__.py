"""A linkage of one's own: a crank, a coupler and a rocker."""
