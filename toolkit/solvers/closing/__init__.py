"""Search for positions that close the joints, where a start or a step has failed: how near they come, how far drivers lead."""
