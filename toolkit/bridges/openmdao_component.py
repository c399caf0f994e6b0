"""Responses as an explicit component of OpenMDAO, with exact partial derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from toolkit.bridges.packages import package
from toolkit.bridges.vector_function import VectorFunction
from toolkit.door.model import Model
from toolkit.foundation.errors import InputError, ToolkitError


def for_openmdao(model: Model, responses: str | Sequence[str], analysis: str = "statics") -> Any:
    """A component whose inputs are the model's variables, and whose outputs are responses.

    Parameters
    ----------
    model
        What `compile` has made, with the variables that are inputs.
    responses
        Names of the outputs.
    analysis
        "statics" or "simulate".

    Returns
    -------
    component
        An `openmdao.api.ExplicitComponent`. Inputs and outputs are called as the variables and responses are, with underscores where these
        have dots: `points_A_x`. Its attribute `function.last` is the last run, with its verdict.

    Raises
    ------
    InputError
        The model has no variables, a response is unknown, or two names are the same to OpenMDAO.
    BridgeError
        OpenMDAO is not installed.

    Notes
    -----
    A design that cannot be solved raises OpenMDAO's AnalysisError, which its drivers and solvers know how to step back from. Partials
    can be checked by central differences; complex numbers are refused.

    Examples
    --------
    >>> problem.model.add_subsystem("wing", ffrf.bridges.for_openmdao(model, ["shape_mse", "max_stress"]))
    """
    om = package("openmdao.api", "bridges")
    function = VectorFunction(model, responses, analysis)
    inputs, outputs = ([name.replace(".", "_") for name in names] for names in (function.names, function.responses))
    if len({*inputs, *outputs}) < len(inputs) + len(outputs):
        raise InputError(
            f"OpenMDAO cannot tell these apart, underscores for dots: {', '.join(sorted([*inputs, *outputs]))}. Name them otherwise in the "
            "scene's table [design], or name each response once."
        )

    class Responses(om.ExplicitComponent):  # type: ignore[misc, name-defined]  # its base is known only where OpenMDAO is installed
        """Responses of a scene by its design variables."""

        def __init__(self) -> None:
            super().__init__()
            self.function = function

        def setup(self) -> None:
            for name, value in zip(inputs, function.start, strict=True):
                self.add_input(name, val=value)
            for name, unit in zip(outputs, function.units, strict=True):
                self.add_output(name, desc=f"in {unit}" if unit else "")
            self.declare_partials("*", "*")

        def compute(self, inputs_: Any, outputs_: Any, *_: Any) -> None:
            for name, value in zip(outputs, self._both(inputs_)[0], strict=True):
                outputs_[name] = value

        def compute_partials(self, inputs_: Any, partials: Any, *_: Any) -> None:
            for output, row in zip(outputs, self._both(inputs_)[1], strict=True):
                for name, slope in zip(inputs, row, strict=True):
                    partials[output, name] = slope

        def _both(self, given: Any) -> tuple[np.ndarray, np.ndarray]:
            try:
                return function.both(np.array([given[name][0] for name in inputs]))
            except ToolkitError as error:
                raise om.AnalysisError(str(error)) from error

    return Responses()
