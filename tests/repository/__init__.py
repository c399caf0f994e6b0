"""Checks of the project's own text: imports, documentation, what is shipped. `make lint` runs them."""
