"""Solvers: the algorithms behind motions, equilibria and consistent starts; whoever wants their verdict too asks `analyses`."""
