"""Which entries of the loop's matrices can differ from zero."""
