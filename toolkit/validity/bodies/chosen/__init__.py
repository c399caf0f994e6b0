"""Whether what was chosen for a body by runs of the scene still suffices."""
