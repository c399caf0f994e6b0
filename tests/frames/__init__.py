"""Flexible bodies with several floating frames."""
