"""Refusal of keys of a flexible body's table that are neither its own nor parameters of its reduced model."""

from __future__ import annotations

from collections.abc import Iterable

from toolkit.bodies.body import Body, Placed
from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import listed, meant
from toolkit.reduced_model.model import ReducedModel


def refuse_unknown_keys(body: Body, keys: Iterable[str], model: ReducedModel, scene: Placed) -> None:
    """Refuse the first of these keys of a body that its reduced model has no parameter for.

    Raises
    ------
    InputError
        It names the body and the key, and lists its own keys and the parameters.
    """
    unknown = next((key for key in keys if key not in model.nominal), None)
    if unknown is None:
        return
    name = next(name for name, other in scene.bodies.items() if other is body)
    own = type(body).model_fields
    raise InputError(
        f"bodies.{name} has no key {unknown!r}{meant(unknown, [*own, *model.parameters])}, and its reduced model {model.label} has no "
        f"parameter {unknown!r}. Keys: {listed(own)}; parameters: {listed(model.parameters)}. Use one of these names, or state the "
        "parameter in the skin file and run preprocessing again."
    )
