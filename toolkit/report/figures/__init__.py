"""The figures of a report, one per file; each takes the material and gives the drawings that it has something to say for."""
