"""Time curves: what scales a load, or leads a driver, over time."""
