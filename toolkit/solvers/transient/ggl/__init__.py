"""Steps of stabilised index 2."""
