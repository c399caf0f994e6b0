"""Airfoil files of any common format, brought into one normal form or refused."""
