"""Tests of meshes that other programs write."""
