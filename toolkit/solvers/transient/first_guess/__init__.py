"""Where Newton begins: the motion of the last steps, continued."""
