"""Settings run and timed, one after another or side by side."""
