"""Compiled formulas on disk: kept, found again, and announced while they are made."""
