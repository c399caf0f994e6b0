"""Projects of one's own, behind `ffrf new`: folders with scenes that run, to be changed from there."""
