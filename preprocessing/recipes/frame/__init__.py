"""frame.toml: straight beams in space between named nodes."""
