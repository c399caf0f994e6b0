"""The beam elements behind a body, in the plane and in space: what they are made of, and how they deform to second order."""
