"""The picture of a body that was just built: its surface, and where its interface points, clamp, groups and masses are."""
