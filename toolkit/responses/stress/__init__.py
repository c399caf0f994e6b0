"""Stress of flexible bodies as a response."""
