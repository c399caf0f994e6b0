"""The groups of elements that a solid is cut into: every element is in one of them, and each hangs together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from preprocessing.mesh.solid_mesh import SolidMesh, lumps
from toolkit.foundation.errors import InputError
from toolkit.foundation.listed_names import meant


def groups_of_elements(mesh: SolidMesh, groups: list[str]) -> dict[str, Mapping[str, np.ndarray]]:
    """Group -> its elements by kind, as `SolidMesh.blocks`.

    Raises
    ------
    InputError
        Groups are unknown, few, without elements or in lumps, or elements are in none or in two; says what is wrong where.
    """
    _refuse_groups(mesh, groups)
    blocks = {group: mesh.volumes[group] for group in groups}
    _refuse_uncovered(mesh, blocks)
    for group, each in blocks.items():
        _refuse_apart(mesh, group, each)
    return blocks


def count_of_lumps(mesh: SolidMesh, members: list[np.ndarray]) -> int:
    """Into how many lumps some elements or faces (n, n_local) fall."""
    return len(np.unique(lumps(len(mesh.nodes), members)[np.concatenate([each.ravel() for each in members])]))


def _refuse_groups(mesh: SolidMesh, groups: list[str]) -> None:
    known = ", ".join(map(repr, mesh.volumes)) or "none"
    for group in groups:
        if group not in mesh.volumes:
            what = "has no elements of the volume" if group in mesh.groups else "is not in the mesh"
            raise InputError(
                f"group {group!r} {what}{meant(group, mesh.volumes)}; groups with such elements: {known}. Name some of these (gmsh: "
                "Physical Volume)."
            )
    if len(set(groups)) < len(groups) or len(groups) < 2:
        raise InputError(
            f"a body is cut into two different groups at least, and here are {', '.join(map(repr, groups))}; there are {known}. Leave "
            "[pieces] out for a body of one frame."
        )


def _refuse_uncovered(mesh: SolidMesh, blocks: Mapping[str, Mapping[str, np.ndarray]]) -> None:
    """Refuse elements that are in no group, or in two."""
    for kind, every in mesh.blocks.items():
        listed = [each[kind] for each in blocks.values() if kind in each]
        found = np.concatenate([np.zeros((0, every.shape[1]), int), *listed])
        _, first, count = np.unique(np.sort(np.vstack([every, found]), axis=1), axis=0, return_index=True, return_counts=True)
        for wrong, what in ((count < 2, "no group"), (count > 2, "more than one group")):
            if np.any(wrong):
                place = ", ".join(f"{x:.4g}" for x in mesh.nodes[every[first[wrong].min()]].mean(axis=0))
                raise InputError(
                    f"{np.count_nonzero(wrong)} elements are in {what} of {', '.join(map(repr, blocks))}, the first round ({place}). Let "
                    "every element be in one of them."
                )


def _refuse_apart(mesh: SolidMesh, group: str, blocks: Mapping[str, np.ndarray]) -> None:
    count = count_of_lumps(mesh, [*blocks.values()])
    if count > 1:
        raise InputError(f"group {group!r} consists of {count} lumps that share no nodes. Make a group of each.")
