"""What a scene makes one ask before anything runs."""
