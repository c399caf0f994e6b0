"""Reference conditions that tie a body's frame to two of its interface points."""
