"""How a random deck of Abaqus is made: bodies, their truth, and the ways to write them."""
