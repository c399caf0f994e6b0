"""Finite elements: what each states, the beams and solids among them, and the sections that they are made of."""
