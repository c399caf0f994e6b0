"""Responses with their exact gradients as functions of other packages: SciPy, OpenMDAO, JAX, PyTorch."""

from toolkit.bridges.jax_function import for_jax
from toolkit.bridges.openmdao_component import for_openmdao
from toolkit.bridges.scipy_function import for_scipy
from toolkit.bridges.torch_function import for_torch

__all__ = ["for_jax", "for_openmdao", "for_scipy", "for_torch"]
