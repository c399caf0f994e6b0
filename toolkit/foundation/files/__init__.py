"""Files: written as a whole or not at all, and read as if an enemy had written them."""
