"""Refusal of texts and numbers of a reduced model that are of the wrong kind or have no unit."""

from __future__ import annotations

from pathlib import Path

from toolkit.foundation.units import LARGEST, SMALLEST, UNIT_SYSTEMS
from toolkit.reduced_model.checks.refusal import refuse
from toolkit.reduced_model.description.composition import read_composition
from toolkit.reduced_model.model import ReducedModel


def check_attributes(model: ReducedModel, path: Path) -> None:
    """Refuse attributes that are not texts or numbers as they should be, and parameters without units."""
    if model.dimension not in (2, 3):
        refuse(path, "dimension", f"is {model.dimension} instead of 2 or 3")
    if model.units not in UNIT_SYSTEMS:
        refuse(path, "units", f"is {model.units!r} instead of one of {', '.join(UNIT_SYSTEMS)}")
    texts = {name: getattr(model, name) for name in ("reference_condition", "basis", "input_hash")}
    for group in ("nominal_units", "writers", "inputs", "source"):
        texts |= {f"{group}/{name}": value for name, value in getattr(model, group).items()}
    for name, value in texts.items():
        if not isinstance(value, str):
            refuse(path, name, f"is {value!r} instead of a text")
    if foreign := set(model.source) - set(model.inputs):
        refuse(path, f"source/{min(foreign)}", "is not among its inputs")
    for group in ("changes", "left_out", "stress_errors", "stress_error_at", "face_errors"):
        for name, value in getattr(model, group).items():
            if not isinstance(value, (int, float)):
                refuse(path, f"{group}/{name}", f"is {value!r} instead of a number")
    try:
        read_composition(model.composition, model.dimension)
    except ValueError as error:
        refuse(path, "composition", f"cannot be right: {error}")
    for name, value in model.nominal.items():
        if not isinstance(value, (int, float)) or not (value == 0 or SMALLEST <= abs(value) <= LARGEST):
            refuse(path, f"nominal/{name}", f"is {value!r} instead of a number that is zero or from {SMALLEST:g} to {LARGEST:g}")
        if name not in model.nominal_units:
            refuse(path, f"nominal_units/{name}", "is missing")
