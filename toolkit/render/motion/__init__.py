"""A motion in pictures: which instants are drawn, and moving pictures."""
