"""frame.toml: straight beams in the plane or in space between named nodes."""
