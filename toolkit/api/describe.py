"""The description of a reduced model for its reader."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from toolkit.foundation.units import unit
from toolkit.foundation.value_types import Record
from toolkit.reduced_model.body_summary import body_summary
from toolkit.reduced_model.file import SCHEMA, SCHEMA_VERSION, load
from toolkit.reduced_model.model import InterfacePoint, ReducedModel
from toolkit.reduced_model.questions import face_record, mesh_record

if TYPE_CHECKING:
    from toolkit.reduced_model.dependence import Derivatives, SparsePolynomial

PLAIN = "plain HDF5 of another program: no checksum tells whether a bit of it was flipped"


def describe(model: str | Path | ReducedModel) -> dict[str, object]:
    """Content of a reduced model, as `ffrf inspect --json` prints it: its body, basis, parameters and what depends on them.

    Parameters
    ----------
    model
        The file, or what `preprocessing.build` has returned.

    Returns
    -------
    record
        Numbers, texts, lists and tables. `record["body"]` holds mass, centre, inertia, volume, number of nodes, elements by kind, what was
        left out of the mesh file, and where interface points and groups are.

    Raises
    ------
    ModelFileError
        The file is missing, damaged or no reduced model.
    """
    model = model if isinstance(model, ReducedModel) else load(model)
    length, judged, faces = unit(model.units, "length"), mesh_record(model), face_record(model)
    return {
        "schema": f"{SCHEMA}, version {SCHEMA_VERSION}",
        **({"form": PLAIN} if model.plain else {}),
        "units": model.units,
        "dimension": model.dimension,
        "body": body_summary(model),
        "reference_condition": model.reference_condition,
        "basis": model.basis,
        "parameters": {name: {"value": value, "unit": model.nominal_units[name]} for name, value in model.nominal.items()},
        "sizes": sizes(model),
        "interfaces": {name: describe_interface(point, length) for name, point in (model.interfaces or {}).items()},
        "exact_for_every_value": dependences(model, model.affine),
        "derivatives": dependences(model, model.derivatives),
        **({"stress_error": judged} if judged else {}),
        **({"face_error": faces} if faces else {}),
        "writers": dict(model.writers),
        "input_hash": model.input_hash,
    }


def dependences(model: ReducedModel, items: Mapping[str, SparsePolynomial | Derivatives] | None) -> dict[str, str]:
    """Arrays that depend on each parameter, by polynomials or by derivatives."""
    found = {
        parameter: ", ".join(item for item, dependence in (items or {}).items() if dependence.depends_on(k))
        for k, parameter in enumerate(model.parameters)
    }
    return {parameter: names for parameter, names in found.items() if names}


def sizes(model: ReducedModel) -> dict[str, int]:
    """Numbers of coordinates, points and elements."""
    found = {"elastic coordinates": model.n_f, "stress points": len(model.invariants.stress_operator)}
    if model.shape is not None:
        found["points with a target"] = len(model.shape.target)
    if model.mesh is not None:
        found |= {"nodes": len(model.mesh.nodes), "elements": len(model.mesh.connectivity)}
    if model.pieces is not None and model.elements is not None:
        found["pieces"] = len(model.elements.connectivity)
    if model.surface is not None:
        parts = {"triangles": len(model.surface.triangles), "lines": len(model.surface.lines)}
        found |= {f"{what} of the surface": count for what, count in parts.items() if count}
    if model.surface_loads:
        found["surfaces for pressure"] = len(model.surface_loads)
    return found


def describe_interface(point: InterfacePoint, length: str) -> Record:
    """Position of an interface point and how far it may be moved."""
    low, high = (float(end) for end in point.arc_length_range)
    movable = f"from {low:.6g} to {high:.6g}" if low < high else "no: at a node, no derivative by the arc length"
    return {"arc_length": float(point.arc_length), "unit": length, "movable": movable}
