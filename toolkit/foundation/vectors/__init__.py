"""Sums of multiples of rows, several numbers at a time, with their code for the compiler."""
