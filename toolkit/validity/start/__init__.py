"""What the search for a consistent start did to what was written."""
