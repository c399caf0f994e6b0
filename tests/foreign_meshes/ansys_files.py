"""Blocks of archives of Ansys (.cdb), as CDWRITE writes them."""

from __future__ import annotations

import numpy as np


def node_block(nodes: np.ndarray, first: int = 1) -> str:
    """NBLOCK with zeros at the end left out, as Ansys does."""
    rows = []
    for k, place in enumerate(nodes):
        last = max(np.flatnonzero(place), default=-1) + 1
        rows.append(f"{first + k:9d}{0:9d}{0:9d}" + "".join(f"{x:21.13E}" for x in place[:last]))
    return (
        f"NBLOCK,6,SOLID,{first + len(nodes) - 1:10d},{len(nodes):10d}\n(3i9,6e21.13e3)\n"
        + "\n".join(rows)
        + "\nN,R5.3,LOC,       -1,\n"
    )


def element_block(*elements: tuple[int, list[int]]) -> str:
    """EBLOCK of elements of a local type with their nodes."""
    rows = []
    for label, (local, nodes) in enumerate(elements, 101):
        head = [1, local, 1, 1, 0, 0, 0, 0, len(nodes), 0, label]
        rows += ["".join(f"{number:9d}" for number in [*head, *nodes[:8]]), "".join(f"{number:9d}" for number in nodes[8:])]
    return f"EBLOCK,19,SOLID,{len(elements)},{len(elements)}\n(19i9)\n" + "\n".join(row for row in rows if row) + "\n       -1\n"


def component(name: str, kind: str, *labels: int) -> str:
    """CMBLOCK of nodes or elements."""
    rows = ["".join(f"{label:10d}" for label in labels[k : k + 8]) for k in range(0, len(labels), 8)]
    return f"CMBLOCK,{name:8},{kind},{len(labels):8d}  ! users component\n(8i10)\n" + "\n".join(rows) + "\n"
