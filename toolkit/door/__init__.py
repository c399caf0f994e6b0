"""The door: what a user imports from `toolkit`, and what the commands use too."""
