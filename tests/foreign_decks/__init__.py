"""Files of other finite-element programs: small ones with values from outside, and random ones whose truth is known by construction."""
