"""What a mesh file holds, as plain arrays: the record that the reader of every format returns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

Elements = list[tuple[str, np.ndarray]]
"""Kind of element in the words of meshio, and the nodes (n_e, n_local) of the elements of that kind, as places among the points."""


class PointMass(NamedTuple):
    """Concentrated mass with its rotary inertia, such as MASS and ROTARYI of Abaqus or CONM2 of Nastran."""

    place: tuple[float, ...]  # of its centre of mass, as many coordinates as the points have
    mass: float
    carriers: np.ndarray  # places among the points of the nodes that it moves with: its own node, or those of a rigid body
    inertia: tuple[float, ...] = (0.0,) * 6  # tensor J about the centre of mass: J_xx, J_yy, J_zz, J_xy, J_xz, J_yz
    rigid: bool = True  # whether several carriers are rigid (RBE2, *RIGID BODY), or it follows their mean (RBE3, *DISTRIBUTING)
    source: str = ""  # "MASS, line 40"


class LeftOut(NamedTuple):
    """Entry of the file that is not part of the body."""

    what: str  # name of the keyword, card or element type
    number: int  # how many of it
    why: str  # in words


class MeshContents(NamedTuple):
    """Nodes, elements and groups of a mesh file; every one of its elements is in `cells`, in `masses` or in `left_out`."""

    points: np.ndarray  # (n, 2) or (n, 3), in the order of the file
    cells: Elements
    groups: list[tuple[str, Elements]]  # name, nodes ("vertex") or elements; of one that is here twice the first tells the nodes
    labels: np.ndarray = np.zeros(0, np.int64)  # (n,) number of every node in the file; none where the format counts them
    masses: Sequence[PointMass] = ()
    left_out: Sequence[LeftOut] = ()
    remarks: Sequence[str] = ()  # what the user should know of the reading, full sentences

    def sent(self) -> dict[str, Any]:
        """Record of the contents as a reader's process sends it: lists, texts, numbers and arrays."""
        return {
            **self._asdict(),
            "masses": [each._asdict() for each in self.masses],
            "left_out": [each._asdict() for each in self.left_out],
        }

    @classmethod
    def received(cls, found: Mapping[str, Any]) -> MeshContents:
        """Contents from the record that was sent.

        Raises
        ------
        TypeError
            It is none.
        """
        masses = [PointMass(**each) for each in found.get("masses", ())]
        return cls(**{**found, "masses": masses, "left_out": [LeftOut(**each) for each in found.get("left_out", ())]})
