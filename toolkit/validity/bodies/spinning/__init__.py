"""Bodies whose frames spin: critical speeds, and the stiffening that linear bodies lack."""
