"""Design sensitivities of a whole run, and the numerical methods that judge them."""
