"""Bodies whose reduced basis is frozen and that are asked about another design, or about derivatives by what would turn their shapes."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from toolkit.bodies.model_body import ModelBody
from toolkit.reduced_model.frozen_basis import RICHER_PARTS, RicherModel, is_frozen, richer_model, turns
from toolkit.reduced_model.model import ReducedModel, place_parameter
from toolkit.responses.stress import model_parameter
from toolkit.scene.resolution import loaded
from toolkit.scene.scene import Scene

PARTS = ("affine", "derivatives", *RICHER_PARTS)
MODES_ALONE = "frozen: eigenmodes"
"""Beginning of the name of a basis whose shapes know no interface points."""


@dataclass(frozen=True)
class FrozenBody:
    """A body whose basis is frozen.

    Attributes
    ----------
    model
        Its reduced model, for messages.
    moved
        Parameter that turns its shapes -> its value, and that which the shapes are for; of those whose values differ.
    asked
        Variables that turn its shapes.
    shapes
        How many its basis has, and how many the richer one of its file has; zero if there is none.
    """

    name: str
    model: str
    moved: dict[str, tuple[float, float]]
    asked: tuple[str, ...]
    shapes: tuple[int, int]

    @property
    def known(self) -> bool:
        """Whether the body's file holds it in more shapes."""
        return self.shapes[1] > 0


def frozen_bodies(scene: Scene, variables: Collection[str] = ()) -> list[FrozenBody]:
    """Frozen bodies whose shapes are not for the design of the scene, or that some variables would turn."""
    return [*filter(None, (_frozen(scene, name, body, variables) for name, body in scene.bodies.items()))]


def with_richer_bases(scene: Scene) -> Scene:
    """The scene with more shapes in all frozen bodies whose files hold them."""
    bodies = {
        name: body.model_copy(update={"model": RicherModel(body.model)})
        for name, body in scene.bodies.items()
        if isinstance(body, ModelBody) and _has_more(scene, body)
    }
    return scene.model_copy(update={"bodies": {**scene.bodies, **bodies}})


def _has_more(scene: Scene, body: ModelBody) -> bool:
    return is_frozen(scene.model(body.model)) and scene.model(body.model, *RICHER_PARTS).richer_invariants is not None


def _frozen(scene: Scene, name: str, body: Any, variables: Collection[str]) -> FrozenBody | None:
    if not isinstance(body, ModelBody) or isinstance(body.model, RicherModel) or not is_frozen(scene.model(body.model)):
        return None
    moved, asked = dict(_moved(scene, body)), [*_asked(scene, name, variables)]
    if not moved and not asked:
        return None
    model = scene.model(body.model, *PARTS)
    off = {parameter: each for parameter, each in moved.items() if _turns(model, parameter)}
    turned = tuple(dict.fromkeys(x for x, parameter in asked if _turns(model, parameter)))
    more = 0 if model.richer_invariants is None else richer_model(model).n_f
    return FrozenBody(name, model.label, off, turned, (model.n_f, more)) if off or turned else None


def _moved(scene: Scene, body: ModelBody) -> Iterator[tuple[str, tuple[float, float]]]:
    """Parameters and positions whose values differ from those of the model."""
    model = scene.model(body.model)
    nominal = {place_parameter(name): float(each.arc_length) for name, each in (model.interfaces or {}).items()} | model.nominal
    given = {**body.model_values(), **{place_parameter(name): s for name, s in loaded(scene).arc_lengths(body).items()}}
    for parameter, value in given.items():
        if parameter in nominal and np.real(value) != nominal[parameter]:
            yield parameter, (float(np.real(value)), nominal[parameter])


def _asked(scene: Scene, name: str, variables: Collection[str]) -> Iterator[tuple[str, str]]:
    """Variables with the parameters of the body that they drive."""
    for variable in scene.design_variables(list(variables)) if variables else ():
        for parameter in filter(None, (model_parameter(scene, name, path) for path in variable.paths)):
            yield variable.name, parameter


def _turns(model: ReducedModel, parameter: str) -> bool:
    """Whether a parameter, or the place of an interface point, turns the shapes; few shapes alone may not show it."""
    if parameter in model.nominal:
        return turns(model if model.richer_invariants is None else richer_model(model), parameter)
    return not model.basis.startswith(MODES_ALONE)
