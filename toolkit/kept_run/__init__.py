"""What a results file holds, and the state in which the run that it keeps has ended."""
