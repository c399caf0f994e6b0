"""Shear of thick beams, which Euler-Bernoulli elements leave out: in deflections and in vibrations, by the plane in which they bend."""
