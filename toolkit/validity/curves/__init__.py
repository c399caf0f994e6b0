"""What a run saw of the time curves of its loads and drivers, and what these do between and after their values."""
