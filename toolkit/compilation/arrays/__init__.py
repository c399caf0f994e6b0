"""Bodies, markers, joints and loads as the flat arrays of the compiled loop."""
