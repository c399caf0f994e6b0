"""Content of a results file, and the state in which the run that it keeps has ended."""
