"""Responses for `scipy.optimize`: a function and its derivatives, each design solved once for both."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolkit.analyses.sensitivity.run import Run
from toolkit.api.model import Model
from toolkit.bridges.vector_function import DesignNumbers, VectorFunction


class ScipyFunction:
    """A function with its derivatives and names, ready for `scipy.optimize`, as `for_scipy` returns it.

    Attributes
    ----------
    fun, jac
        Value and gradient of one response, a number and (n,); of several their values (m,) and derivatives (m, n).
    x0
        The variables where the model stands, (n,).
    names
        Variables in the order of x.
    last
        The run of the last design that this process solved, with its verdict; none before the first.
    """

    def __init__(self, function: VectorFunction, single: bool) -> None:
        self._function, self._single = function, single
        self.names, self.x0 = function.names, function.start.copy()

    def fun(self, x: DesignNumbers) -> float | np.ndarray:
        """Value or values at x: numbers (n,) in the order of `names`, or what names them, as a row of pandas or a dictionary."""
        values = self._function.values(x)
        return float(values[0]) if self._single else values

    def jac(self, x: DesignNumbers) -> np.ndarray:
        """Derivatives at x, in the order of `names`."""
        slopes = self._function.slopes(x)
        return slopes[0] if self._single else slopes

    @property
    def last(self) -> Run | None:
        """Run of the last design that was solved."""
        return self._function.last


def for_scipy(model: Model, response: str | Sequence[str], analysis: str = "statics") -> ScipyFunction:
    """A function and its derivatives, ready for `scipy.optimize.minimize`, `least_squares` and `NonlinearConstraint`.

    Parameters
    ----------
    model
        What `compile` has made, with the variables that x holds.
    response
        Name of a response; or of several, for vectors.
    analysis
        "statics" or "simulate".

    Returns
    -------
    function
        With `fun`, `jac`, `x0`, `names` and `last`.

    Raises
    ------
    InputError
        The model has no variables, or a response is unknown.

    Notes
    -----
    A design that cannot be solved raises the error of its analysis, which ends SciPy's search: no value stands for it. `ffrf.optimize` goes
    on from there. Other processes can be sent the function, as `differential_evolution(..., workers=2)` does; several threads may call it,
    and take turns.

    Examples
    --------
    >>> shape = ffrf.bridges.for_scipy(model, "shape_mse")
    >>> scipy.optimize.minimize(shape.fun, shape.x0, jac=shape.jac, method="L-BFGS-B")
    """
    return ScipyFunction(VectorFunction(model, response, analysis), isinstance(response, str))
