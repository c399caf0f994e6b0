"""Symmetric contractions with a basis: Psi^T K Psi part by part, with the digits that the roots of the parts keep."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.sparse import csr_array, issparse

from preprocessing.assembly.assembly import Part, Parts
from preprocessing.elements.section import monomial


def energies(parts: Parts, values: Mapping[str, Any], name: str, psi: Any) -> Any:
    """Energy matrix Psi^T K Psi or Psi^T D Psi (`name` stiffness or damping), (n_f, n_f); sparse as Psi is.

    Thin beams are a million times stiffer along than across. In K u of a shape that bends, the stiff parts cancel and take six
    digits along; as the square of a strain they are what they are.
    """
    own = [part for part in parts.parts if part.name == name]
    nothing = csr_array((psi.shape[1],) * 2) if issparse(psi) else np.zeros((psi.shape[1],) * 2)
    return sum((monomial(values, part.factors) * energy(part, psi) for part in own), nothing)


def energy(part: Part, psi: Any) -> Any:
    """Contribution of one part to an energy matrix for unit parameters; Psi sparse or dense."""
    if part.root is None:
        return symmetric(psi.T @ (part.matrix @ psi))
    strain = part.root.rows @ psi
    return part.root.weight * (strain.T @ strain)


def symmetric(matrix: Any) -> Any:
    """Symmetric part of a matrix, without the round-off of products that makes it unsymmetric."""
    return (matrix + matrix.T) / 2


def antisymmetric(matrix: Any) -> Any:
    """Antisymmetric part of a matrix, without the round-off of products that makes it another one."""
    return (matrix - matrix.T) / 2


PARTS = {"symmetric": symmetric, "antisymmetric": antisymmetric, "whole": lambda matrix: matrix}
"""Parts of a product that are an invariant, by the words of `preprocessing.elements.space.Form`."""
