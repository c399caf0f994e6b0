"""Bodies under compression: what geometric stiffness, which the equations lack, would take from them, and how near they are to buckling."""
