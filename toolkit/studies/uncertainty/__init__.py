"""What follows from numbers that are not known exactly: means, spreads, shares of variables, and probabilities."""
