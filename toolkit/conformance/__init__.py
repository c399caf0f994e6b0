"""Checks that a joint or a load of one's own is right: every derivative against a complex step, with the wrong one named."""
