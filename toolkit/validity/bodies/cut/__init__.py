"""Bodies with several floating frames, looked at as one body."""
