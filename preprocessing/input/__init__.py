"""Input files, and where a reduced model may be written."""
