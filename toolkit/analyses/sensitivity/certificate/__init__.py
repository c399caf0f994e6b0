"""How far independent methods agree on the gradients of a scene."""
