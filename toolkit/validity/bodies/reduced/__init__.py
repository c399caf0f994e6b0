"""What cut bodies lack whose parts keep some of their shapes only, in runs and in frequencies."""
