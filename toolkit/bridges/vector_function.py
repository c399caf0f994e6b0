"""Responses of a model as a vector that depends on a vector: what every bridge is made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from threading import Lock
from types import ModuleType
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from toolkit.analyses.sensitivity.preparation import responses_of
from toolkit.analyses.sensitivity.run import Run
from toolkit.api.model import Model, compile_model, kind_of
from toolkit.foundation.errors import InputError, ToolkitError, listed, meant

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


DesignNumbers: TypeAlias = "ArrayLike | Mapping[str, float]"
"""Numbers of a design in the order of the variables, or what names them: a dictionary, a named tuple, a row of a table."""


class BridgeError(ToolkitError, RuntimeError):
    """A bridge leads to a package that is not installed, or is not set up as it must be; the message says what to do."""


def package(name: str, extra: str) -> ModuleType:
    """A package of the other side.

    Raises
    ------
    BridgeError
        It is not installed; says how to.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise BridgeError(
            f"this bridge needs {name}, which cannot be imported ({error}). Install: pip install 'ffrf-toolkit[{extra}]'."
        ) from error


class VectorFunction:
    """Responses by the variables of a model, each design solved once for values and derivatives.

    Several threads may ask at once and get the numbers of their own designs; they are solved one after another. Another process gets the
    function with its model, and no run.

    Parameters
    ----------
    model
        What `compile` has made, with the variables that the vector holds.
    responses
        Names of the responses in the order of the result; a single name is a vector of one.
    analysis
        "statics" or "simulate".

    Raises
    ------
    InputError
        The model has no variables, or a response is unknown.
    """

    def __init__(self, model: Model, responses: str | Sequence[str], analysis: str = "statics") -> None:
        if not isinstance(model, Model):
            raise InputError(
                f"a bridge begins at a model, not {type(model).__name__}. Make one: ffrf.compile(scene, variables=[...])."
            )
        self.kind = kind_of(analysis)
        self.names = tuple(model.variables)
        if not self.names:
            raise InputError("functions of what? The model has no design variables. Name some: compile(scene, variables=[...]).")
        self.responses = (responses,) if isinstance(responses, str) else tuple(responses)
        _refuse_unknown(model, self.responses, self.kind == "transient")
        chosen = {name: model.scene.responses[name] for name in dict.fromkeys(self.responses)}
        asked = model.scene.model_copy(update={"responses": chosen})
        self._model = compile_model(asked, self.names)
        self.start = np.array(list(model.variables.values()))
        known = responses_of(model.scene, moving=self.kind == "transient")
        self.units = tuple(known[name].unit(model.scene.units) for name in self.responses)
        self._begin()

    def _begin(self) -> None:
        self.last: Run | None = None
        self._solved: tuple[bytes, np.ndarray, np.ndarray] | None = None
        self._turn = Lock()

    def __getstate__(self) -> dict[str, object]:
        return {name: value for name, value in vars(self).items() if name not in ("last", "_solved", "_turn")}

    def __setstate__(self, state: dict[str, object]) -> None:
        vars(self).update(state)
        self._begin()

    def both(self, x: DesignNumbers) -> tuple[np.ndarray, np.ndarray]:
        """Values (m,) and derivatives (m, n) at x (n,), solved unless x is the last one.

        What says which number is which, as a row of pandas, a dictionary or a named tuple do, is taken by its names.

        Raises
        ------
        InputError
            x has another length or other names, or is not real and finite.
        ToolkitError
            The design cannot be solved; says why.
        """
        numbers = self._checked(x)
        with self._turn:
            if self._solved is None or self._solved[0] != numbers.tobytes():
                self._solved = None
                self.last, values, slopes = self._solve(numbers)
                self._solved = (numbers.tobytes(), values, slopes)
            return self._solved[1].copy(), self._solved[2].copy()

    def values(self, x: DesignNumbers) -> np.ndarray:
        """Values (m,) at x (n,)."""
        return self.both(x)[0]

    def slopes(self, x: DesignNumbers) -> np.ndarray:
        """Derivatives (m, n) at x (n,)."""
        return self.both(x)[1]

    def _solve(self, x: np.ndarray) -> tuple[Run, np.ndarray, np.ndarray]:
        run = self._model.run(self.kind, dict(zip(self.names, map(float, x), strict=True)), gradients=True)
        values = np.array([run.values[name] for name in self.responses])
        slopes = np.array([[run.gradients[name][each] for each in self.names] for name in self.responses])
        return run, values, slopes

    def _checked(self, x: DesignNumbers) -> np.ndarray:
        try:
            found = np.asarray(_in_order(x, self.names))
            if np.iscomplexobj(found):
                raise InputError("these functions take real numbers: their derivatives are exact, and need no complex step.")
            found = np.array(found, float)
        except (TypeError, ValueError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{self._wanted()}; given: something else, of type {type(x).__name__}.") from error
        if found.shape != self.start.shape or not np.all(np.isfinite(found)):
            raise InputError(f"{self._wanted()}; given: an array of shape {found.shape}.")
        return found

    def _wanted(self) -> str:
        return f"{len(self.names)} finite numbers are needed, for {', '.join(self.names)}"


def _in_order(x: DesignNumbers, names: Sequence[str]) -> object:
    """Numbers of x in the order of the names, if x names them itself; else x as it is."""
    named = _named(x)
    if named is None:
        return x
    if wrong := [name for name in named if name not in names]:
        raise InputError(
            f"a design with names is taken by its names, and {wrong[0]!r} is no variable{meant(str(wrong[0]), names)}; the variables: "
            f"{', '.join(names)}. Leave out all others, or give the numbers alone, in this order."
        )
    if lacking := [name for name in names if name not in named]:
        raise InputError(f"a design with names is taken by its names, and {lacking[0]!r} is not among them. Add it.")
    return [named[name] for name in names]


def _named(x: DesignNumbers) -> dict[str, float] | None:
    """Name -> number of a dictionary, a named tuple or a row of a table; none of what counts its numbers only."""
    if isinstance(x, Mapping):
        return dict(x)
    if isinstance(x, tuple):
        return dict(zip(fields, x, strict=True)) if (fields := getattr(x, "_fields", None)) else None
    index = getattr(x, "index", None)  # of pandas; of a list it is a method
    if index is None or callable(index) or np.ndim(x) != 1:
        return None
    labels = list(index)
    if labels == list(range(len(labels))):
        return None
    if len(set(labels)) < len(labels):
        raise InputError("a design with names is taken by its names, and two of them are the same. Name each number once.")
    return dict(zip(labels, np.asarray(x).tolist(), strict=True))


def _refuse_unknown(model: Model, responses: Sequence[str], moving: bool) -> None:
    known = responses_of(model.scene, moving=moving)
    if not responses:
        raise InputError(f"which responses? Possible here: {listed(known)}.")
    for name in responses:
        if name not in known:
            raise InputError(f"no response {name!r}{meant(name, known)}; possible here: {listed(known)}.")
