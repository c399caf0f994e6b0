"""Reduced models of beams along any polygon, for tests of the runtime against closed forms."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from preprocessing.assembly import Rayleigh, assemble, derivative, matrices_at
from preprocessing.interface import interface_point
from preprocessing.invariants import contract, contract_derivative, nonzero, polynomials
from preprocessing.mesh import CurveMesh
from preprocessing.reduction import tangent_frame
from preprocessing.section import PARAMETERS, Section
from preprocessing.stress import stress_points
from toolkit.reduced_model import ReducedModel
from toolkit.reduced_model_file import save


def beam_model(
    nodes: np.ndarray, section: Section, interfaces: Mapping[str, float], damping: Rayleigh | None = None, units: str = "m-kg-s"
) -> ReducedModel:
    """A beam along the polygon `nodes`, its frame tied to the first node; `interfaces` are arc lengths along the polygon."""
    nodes = np.asarray(nodes, float)
    numbers = np.arange(len(nodes))
    mesh = CurveMesh(nodes, np.column_stack([numbers[:-1], numbers[1:]]))
    arc_lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1)))
    parts = assemble(mesh, damping or Rayleigh())
    basis, matrices = tangent_frame(nodes, 0, "the first node"), matrices_at(parts, section)
    rates = {name: contract_derivative(matrices, derivative(parts, section, name), basis.z) for name in PARAMETERS}
    return ReducedModel(
        dimension=2,
        units=units,
        reference_condition=basis.reference_condition,
        basis=basis.description,
        nominal={name: float(getattr(section, name)) for name in PARAMETERS},
        nominal_units=dict.fromkeys(PARAMETERS, ""),
        input_hash="test",
        writers={"tests": "0"},
        invariants=contract(matrices, basis.z),
        derivatives={name: nonzero(rate) for name, rate in rates.items()},
        affine=polynomials(parts, section, basis.z),
        interfaces={name: interface_point(mesh, arc_lengths, basis.z, s) for name, s in interfaces.items()},
        stress=stress_points(len(mesh.connectivity)),
    )


def save_beam(path: Path, *args, **kwargs) -> Path:
    """Build a beam and write it to a file; arguments as `beam_model`."""
    save(beam_model(*args, **kwargs), path)
    return path
