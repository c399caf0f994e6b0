"""The command `ffrf-preprocess`, its picture, and programs that the runtime starts in a process of their own."""
