"""Sweeps: values and gradients at many designs of a study, as tables."""
