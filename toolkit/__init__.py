"""Flexible multibody dynamics with exact design sensitivities: the runtime."""
