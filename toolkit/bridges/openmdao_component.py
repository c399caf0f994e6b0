"""Responses as an explicit component of OpenMDAO, with exact partial derivatives."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from toolkit.api.model import Model
from toolkit.bridges.vector_function import VectorFunction, package
from toolkit.files.gradient_units import variable_unit
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.foundation.units import LABELLED, UNIT_SYSTEMS, unit

if TYPE_CHECKING:
    from openmdao.api import ExplicitComponent
    from openmdao.jacobians.jacobian import Jacobian
    from openmdao.vectors.vector import Vector

WORD = re.compile("[A-Za-z]+")
_POWER = r"[A-Za-z]+(?:\*\*\d)?"
_TERM = rf"(?:{_POWER}|\({_POWER}(?:[*/]{_POWER})*\)(?:\*\*\d)?)"
WRITTEN = re.compile(rf"(?:1/)?{_TERM}(?:[*/]{_TERM})*")
"""A unit in OpenMDAO's writing: words with their powers, products, quotients and brackets around them."""
SOLVED = "solved"
"""Output that says whether there is a value for the last design."""


def for_openmdao(model: Model, responses: str | Sequence[str], analysis: str = "statics") -> ExplicitComponent:
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
        have dots: `points_A_x`. They have the units of the scene, so that OpenMDAO converts from and to others. One more output, `solved`,
        is 1 where the last design was solved, and 0 where it failed. The attribute `function.last` is the last run, with its verdict.

    Raises
    ------
    InputError
        The model has no variables, a response is unknown, or two names are the same to OpenMDAO.
    BridgeError
        OpenMDAO is not installed.

    Notes
    -----
    A design that cannot be solved raises OpenMDAO's AnalysisError; some of its drivers step back from it, most end with it, and the page
    on bridges says which. The outputs keep their values of the design before, and `solved` is 0. Partials can be checked by central
    differences; complex numbers are refused.

    Examples
    --------
    >>> problem.model.add_subsystem("wing", ffrf.bridges.for_openmdao(model, ["shape_mse", "max_stress"]))
    """
    om = package("openmdao.api", "bridges")
    function = VectorFunction(model, responses, analysis)
    inputs, outputs = ([name.replace(".", "_") for name in names] for names in (function.names, function.responses))
    _refuse_namesakes([*inputs, *outputs])
    scene = model.scene
    input_units = [openmdao_units(variable_unit(scene, scene.paths_of(name)[0])) for name in function.names]
    output_units = [openmdao_units(label) for label in function.units]

    class Responses(om.ExplicitComponent):  # type: ignore[misc, name-defined]  # its base is known only where OpenMDAO is installed
        """Responses of a scene by its design variables."""

        def __init__(self) -> None:
            super().__init__()
            self.function = function

        def setup(self) -> None:
            for name, value, units in zip(inputs, function.start, input_units, strict=True):
                self.add_input(name, val=value, units=units)
            for name, units, label in zip(outputs, output_units, function.units, strict=True):
                self.add_output(name, units=units, desc=f"in {label}" if label else "")
            self.add_output(SOLVED, desc="1 where the last design was solved, 0 where it failed")
            self.declare_partials(outputs, inputs)

        def compute(self, inputs_: Vector, outputs_: Vector, *_: object) -> None:
            outputs_[SOLVED] = 0.0
            for name, value in zip(outputs, self._both(inputs_)[0], strict=True):
                outputs_[name] = value
            outputs_[SOLVED] = 1.0

        def compute_partials(self, inputs_: Vector, partials: Jacobian, *_: object) -> None:
            for output, row in zip(outputs, self._both(inputs_)[1], strict=True):
                for name, slope in zip(inputs, row, strict=True):
                    partials[output, name] = slope

        def _both(self, given: Vector) -> tuple[np.ndarray, np.ndarray]:
            try:
                return function.both(np.array([given[name][0] for name in inputs]))
            except ToolkitError as error:
                raise om.AnalysisError(str(error)) from error

    return Responses()


def _refuse_namesakes(names: Sequence[str]) -> None:
    if SOLVED in names:
        raise InputError(
            f"{SOLVED!r} is the output that says whether a design was solved. Give the response or variable another name."
        )
    if len(set(names)) < len(names):
        raise InputError(
            f"OpenMDAO cannot tell these apart, underscores for dots: {', '.join(sorted(names))}. Name them otherwise in the scene's table "
            "[design], or name each response once."
        )


def openmdao_units(label: str) -> str | None:
    """A label of a unit as OpenMDAO writes it, "t*mm**2" for "t mm^2"; none for what has no unit, or another than the toolkit's own."""
    written = label.replace(" ", "*").replace("^", "**")
    own = WRITTEN.fullmatch(written) is not None and set(WORD.findall(written)) <= _words()  # OpenMDAO evaluates it as Python
    return written if own else None


@cache
def _words() -> set[str]:
    return {word for system in UNIT_SYSTEMS for quantity in LABELLED for word in WORD.findall(unit(system, quantity))}
