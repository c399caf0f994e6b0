"""What every room may use: errors, verdicts, units, the decorator of compiled formulas, and rules that no last digit decides."""
