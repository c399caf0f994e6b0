"""Pictures of scenes in the plane, drawn by matplotlib; the report takes the same."""
