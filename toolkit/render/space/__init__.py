"""Pictures of scenes in space, the sister of the pictures in the plane."""
