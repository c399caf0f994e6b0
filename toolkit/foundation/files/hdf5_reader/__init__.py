"""HDF5 read in Python, as far as the program writes it: bytes that nobody can trust never reach compiled code that trusts them.

No library is that guard: HDF5's own, below h5py, follows wrong sizes and addresses out of its memory where their checksums are right
(30 of 6000 such files ended the process), and pyfive 1.3 reads no arrays in the pieces of HDF5 1.10, which our files are made of.
"""
