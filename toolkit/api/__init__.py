"""Public functions and classes: what a user imports from `toolkit`, and what the commands use too."""
