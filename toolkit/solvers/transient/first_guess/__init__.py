"""First guess from which Newton begins: the motion of the last steps, continued."""
