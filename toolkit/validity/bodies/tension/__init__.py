"""Bodies under tension: the stiffness across it that linear FFRF lacks in a body's frame, by loads or by the body's own deflection."""
