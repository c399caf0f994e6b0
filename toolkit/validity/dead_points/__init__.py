"""Whether a motion passes positions in which joints repeat each other."""
