"""Speed against accuracy, measured: a grid of settings against a reference."""
