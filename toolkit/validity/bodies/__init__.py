"""What linear deformation in a moving frame leaves out: large deformation, buckling, centrifugal stiffening."""
