"""One design of a study solved in all cases, and the store of all that were."""
