"""Refusal of reduced models that are incomplete or cannot be physical."""
