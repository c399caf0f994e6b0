"""What the length of the steps does to values and gradients."""
