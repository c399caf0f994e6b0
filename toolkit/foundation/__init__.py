"""Foundation of all rooms: errors, verdicts, units, the decorator of compiled formulas, and rules that no last digit decides."""
