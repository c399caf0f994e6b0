"""Forces and torques of joints as responses."""
