"""The command `ffrf-preprocess`, and programs that the runtime starts in a process of their own."""
