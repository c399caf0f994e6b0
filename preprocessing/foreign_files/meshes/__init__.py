"""Meshes that programs other than Abaqus and Nastran write: gmsh, VTK, Ansys, universal files, MED and more."""
