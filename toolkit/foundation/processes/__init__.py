"""Python and the preprocessing in processes of their own."""
