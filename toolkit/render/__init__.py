"""Pictures; the only place that imports pyvista and matplotlib."""
