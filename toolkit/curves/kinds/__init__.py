"""One file per kind of time curve."""
