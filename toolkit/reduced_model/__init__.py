"""The reduced model of a flexible body, the only thing that both halves of the project share, with its file and its checks."""
