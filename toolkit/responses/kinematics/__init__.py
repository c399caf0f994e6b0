"""Motion of points and bodies as responses: formulas of the poses, rates and accelerations of markers."""
