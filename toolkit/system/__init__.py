"""A scene after its compilation, and its states: the system, its solutions, and where its bodies and markers are."""
