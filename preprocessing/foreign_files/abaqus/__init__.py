"""Input decks of Abaqus and CalculiX, read by their manuals: keyword lines with parameters, and the data lines below each of them."""
