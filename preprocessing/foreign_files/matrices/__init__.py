"""Readers of finished matrices and of tables of numbers that other programs wrote."""
