"""Pictures of scenes in the plane."""
