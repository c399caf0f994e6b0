"""Responses as a function of JAX, differentiated in reverse by their exact gradients."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Protocol, Self

import numpy as np

from toolkit.api.model import Model
from toolkit.bridges.vector_function import BridgeError, VectorFunction, package


class JaxArray(Protocol):
    """An array of JAX, or what stands for one while JAX traces."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the axes."""

    def __matmul__(self, other: Self, /) -> Self:
        """Product of matrices."""


def for_jax(model: Model, responses: str | Sequence[str], analysis: str = "statics") -> Callable[[JaxArray], JaxArray]:
    """A function of JAX: from the variables (n,) to the responses (m,).

    Parameters
    ----------
    model
        What `compile` has made, with the variables that x holds in their order.
    responses
        Names of the responses.
    analysis
        "statics" or "simulate".

    Returns
    -------
    function
        For `jax.grad`, `jax.jacrev`, `jax.jit`; `jax.vmap` solves one design after another. First derivatives, in reverse.

    Raises
    ------
    InputError
        The model has no variables, or a response is unknown.
    BridgeError
        JAX is not installed, or computes in single precision.

    Notes
    -----
    A design that cannot be solved raises JAX's own error (`jax.errors.JaxRuntimeError`) with the reason.

    Examples
    --------
    >>> shape = ffrf.bridges.for_jax(model, "shape_mse")
    >>> jax.value_and_grad(lambda x: shape(x)[0])(jax.numpy.array([1.5, 4200.0]))
    """
    jax = package("jax", "bridges")
    if not jax.config.jax_enable_x64:
        raise BridgeError(
            "JAX computes in single precision, which would cut off half the digits. Before the first array: "
            'jax.config.update("jax_enable_x64", True).'
        )
    function = VectorFunction(model, responses, analysis)
    m, n = len(function.responses), len(function.names)
    values = jax.ShapeDtypeStruct((m,), np.float64)
    both = (values, jax.ShapeDtypeStruct((m, n), np.float64))

    @jax.custom_vjp
    def responses_of(x: JaxArray) -> JaxArray:
        return jax.pure_callback(function.values, values, _vector(jax, x, n), vmap_method="sequential")

    def forward(x: JaxArray) -> tuple[JaxArray, JaxArray]:
        return jax.pure_callback(function.both, both, _vector(jax, x, n), vmap_method="sequential")

    def backward(slopes: JaxArray, cotangent: JaxArray) -> tuple[JaxArray]:
        return (cotangent @ slopes,)

    responses_of.defvjp(forward, backward)
    return responses_of


def _vector(jax: ModuleType, x: JaxArray, n: int) -> JaxArray:
    """x as doubles; another shape or kind is refused while JAX traces, where its own errors of shapes come from too."""
    if jax.numpy.iscomplexobj(x):
        raise TypeError("this function takes real numbers: its derivatives are exact, and need no complex step.")
    if isinstance(x, tuple) and getattr(x, "_fields", None):
        raise TypeError(
            "this function takes an array in the order of the model's variables, and no named tuple, whose order is its own."
        )
    x = jax.numpy.asarray(x, np.float64)
    if x.shape != (n,):
        raise TypeError(f"this function takes the {n} variables of the model as an array ({n},), not {x.shape}.")
    return x
