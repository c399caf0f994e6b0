"""HDF5 read in Python, as far as the program writes it: bytes that nobody can trust never reach compiled code that trusts them."""
