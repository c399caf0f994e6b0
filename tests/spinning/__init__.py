"""Tests of scenes that spin."""
