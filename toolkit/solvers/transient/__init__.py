"""Steps over time: generalized-alpha, Newton's iteration, sensitivities carried along, and the way back of the adjoint."""
