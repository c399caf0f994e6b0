"""Responses of a model as a vector that depends on a vector: what every bridge is made of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from toolkit.door.model import Model, compile_model, kind_of
from toolkit.door.run import Run
from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import listed, meant
from toolkit.sensitivity.preparation import responses_of


class VectorFunction:
    """Responses by the variables of a model, each design solved once for values and derivatives.

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
        self.last: Run | None = None
        self._solved: tuple[bytes, np.ndarray, np.ndarray] | None = None

    def both(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (m,) and derivatives (m, n) at x (n,), solved unless x is the last one.

        Raises
        ------
        InputError
            x has another length, or is not real and finite.
        ToolkitError
            The design cannot be solved; says why.
        """
        x = self._checked(x)
        if self._solved is None or self._solved[0] != x.tobytes():
            self._solved = None
            run = self._model.run(self.kind, dict(zip(self.names, map(float, x), strict=True)), gradients=True)
            values = np.array([run.values[name] for name in self.responses])
            slopes = np.array([[run.gradients[name][x] for x in self.names] for name in self.responses])
            self.last, self._solved = run, (x.tobytes(), values, slopes)
        return self._solved[1].copy(), self._solved[2].copy()

    def values(self, x: np.ndarray) -> np.ndarray:
        """Values (m,) at x (n,)."""
        return self.both(x)[0]

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """Derivatives (m, n) at x (n,)."""
        return self.both(x)[1]

    def _checked(self, x: np.ndarray) -> np.ndarray:
        found = np.asarray(x)
        if np.iscomplexobj(found):
            raise InputError("these functions take real numbers: their derivatives are exact, and need no complex step.")
        found = np.array(found, float)
        if found.shape != self.start.shape or not np.all(np.isfinite(found)):
            raise InputError(
                f"{len(self.names)} finite numbers are needed, for {', '.join(self.names)}; given: an array of shape {found.shape}."
            )
        return found


def _refuse_unknown(model: Model, responses: Sequence[str], moving: bool) -> None:
    known = responses_of(model.scene, moving=moving)
    if not responses:
        raise InputError(f"which responses? Possible here: {listed(known)}.")
    for name in responses:
        if name not in known:
            raise InputError(f"no response {name!r}{meant(name, known)}; possible here: {listed(known)}.")
