"""Tests of loads that depend on states."""
