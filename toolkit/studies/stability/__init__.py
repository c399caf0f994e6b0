"""Where a scene runs stably: maps over settings of the solver and numbers of the scene."""
