"""Mass, centre of mass, power and work as responses."""
