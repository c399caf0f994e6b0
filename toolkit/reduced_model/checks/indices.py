"""Refusal of numbers of nodes, elements, ends and fibres that do not exist."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from toolkit.reduced_model.checks.refusal import numbers_below, refuse
from toolkit.reduced_model.elements import SpatialElements
from toolkit.reduced_model.model import ReducedModel

PARALLEL = 1e-6
"""Sine of the angle between an element and the axis of its section below which they are parallel."""


def check_indices(model: ReducedModel, path: Path) -> None:
    """Refuse numbers of nodes, elements, points, ends and fibres that do not exist."""
    mesh, stress, outline, surface = model.mesh, model.stress, model.outline, model.surface
    elements = model.elements
    if elements is not None and not np.isin(elements.connectivity, np.arange(len(elements.nodes))).all():
        refuse(path, "elements/connectivity", f"names nodes other than 0 to {len(elements.nodes) - 1}")
    if isinstance(elements, SpatialElements) and not np.isin(elements.held, np.arange(len(elements.nodes))).all():
        refuse(path, "elements/held", f"names nodes other than 0 to {len(elements.nodes) - 1}")
    _check_pieces(model, path)
    for name in ("triangles", "lines"):
        if surface is not None and not np.isin(getattr(surface, name), np.arange(len(surface.position))).all():
            refuse(path, f"surface/{name}", f"names points other than 0 to {len(surface.position) - 1}")
    if outline is not None and not np.isin(outline.edges, np.arange(len(outline.position))).all():
        refuse(path, "outline/edges", f"names points other than 0 to {len(outline.position) - 1}")
    if model.interior is not None:
        numbers_below(path, "interior/triangles", model.interior.triangles, len(model.interior.position), "points")
        numbers_below(path, "interior/modulus", model.interior.modulus, len(model.nominal), "parameters")
    if mesh is not None and not np.isin(mesh.connectivity, np.arange(len(mesh.nodes))).all():
        refuse(path, "mesh/connectivity", f"names nodes other than 0 to {len(mesh.nodes) - 1}")
    _check_beams(model, path)
    if stress is None:
        return
    for name, allowed in (("end", (0, 1)), ("fibre", (-1, 1))):
        if not np.isin(getattr(stress, name), allowed).all():
            refuse(path, f"stress/{name}", f"holds numbers other than {allowed[0]} and {allowed[1]}")
    if mesh is not None and not np.isin(stress.element, np.arange(len(mesh.connectivity))).all():
        refuse(path, "stress/element", f"names elements other than 0 to {len(mesh.connectivity) - 1}")


def _check_pieces(model: ReducedModel, path: Path) -> None:
    """Refuse pieces and loads on them whose numbers of rows, points or elements do not fit the body."""
    elements, points, components = model.elements, *model.invariants.stress_operator.shape[:2]
    if isinstance(elements, SpatialElements):
        if len(elements.stress_operator) != points * components:
            refuse(path, "elements/stress_operator", f"has {len(elements.stress_operator)} rows instead of {points * components}")
        if model.pieces is not None:
            numbers_below(path, "pieces/element", model.pieces.element, len(elements.connectivity), "elements")
        if model.stress is not None:
            numbers_below(path, "stress/element", model.stress.element, len(elements.connectivity), "elements")
    for name, load in (model.piece_loads or {}).items():
        if isinstance(elements, SpatialElements) and len(load.force) != len(elements.connectivity):
            refuse(path, f"piece_loads/{name}/force", f"has {len(load.force)} rows instead of {len(elements.connectivity)}")
    if model.face_errors and not ({"least", "largest"} < model.face_errors.keys()):
        refuse(path, "face_errors", 'lacks "least", "largest" or the errors by single forces')
    if model.pieces is not None and model.surface is not None and len(model.pieces.element) != len(model.surface.position):
        refuse(
            path, "pieces/element", f"tells {len(model.pieces.element)} points of {len(model.surface.position)} of the surface"
        )


def _check_beams(model: ReducedModel, path: Path) -> None:
    """Refuse sections that are not as many as the beams, or whose axis lies along their element."""
    sections, beams = model.sections, model.mesh or model.elements
    if sections is None or beams is None:
        return
    if len(sections.axis) != len(beams.connectivity):
        refuse(path, "sections/axis", f"has {len(sections.axis)} elements instead of {len(beams.connectivity)}")
    sides = np.zeros((len(sections.axis), 3))
    sides[:, : model.dimension] = beams.nodes[beams.connectivity[:, 1]] - beams.nodes[beams.connectivity[:, 0]]
    sizes = np.linalg.norm(sides, axis=1) * np.linalg.norm(sections.axis, axis=1)
    if np.any(np.linalg.norm(np.cross(sides, sections.axis), axis=1) <= PARALLEL * sizes):
        refuse(path, "sections/axis", "runs along an element, across which it should lie")
