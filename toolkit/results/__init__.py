"""Results of a run as plain arrays with names, and the file that keeps them."""
