"""From a scene to the flat arrays of the compiled loop."""
