"""Responses: the numbers that a design is judged by, with their derivatives."""
