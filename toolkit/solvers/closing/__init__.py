"""Whether joints can be closed at all, asked where a start or a step has failed: how near they come, and how far drivers lead."""
