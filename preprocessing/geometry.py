"""The geometry of one skin: both airfoils read, F and G found, the curve cut and meshed, the target matched."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from preprocessing.airfoil import read_airfoil
from preprocessing.contour import Contour
from preprocessing.mesh import CurveMesh, mesh_curve
from preprocessing.skin import Skin
from preprocessing.skin_file import SkinFile
from preprocessing.slenderness import slenderness
from toolkit.errors import InputError

Remark = Callable[[str], None]
_METRES = {"mm-t-s": 1e-3, "m-kg-s": 1.0, "mm": 1e-3, "m": 1.0}
"""Metres per unit of length of the unit systems and of airfoil files."""


@dataclass(frozen=True)
class Geometry:
    """The skin, its nodes and the places they shall reach, in the units of skin.toml."""

    skin: Skin
    arc_lengths: np.ndarray  # (n_nodes,) from F along the true curve
    mesh: CurveMesh
    target: np.ndarray  # (n_nodes, 2)
    outline: np.ndarray  # (n_points, 2)
    target_outline: np.ndarray  # (n_points, 2)


def read_geometry(path: Path, file: SkinFile, remark: Remark | None = None) -> Geometry:
    """Geometry of the skin that skin.toml (at `path`, content `file`) describes.

    `remark` is called with every repair of an airfoil file and every warning about it or the thickness, in words.

    Raises
    ------
    InputError
        An airfoil file cannot be used, or F, G, the thickness or the target do not fit to it; names the file and the key.
    """
    with at_key(path, "airfoil.file"):
        contour = _contour(path.parent / file.airfoil.file, file, remark)
    with at_key(path, "airfoil.target"):
        target = _contour(path.parent / file.airfoil.target, file, remark)
    skin = _cut(path, file, contour)
    with at_key(path, "skin"):
        arc_lengths = skin.stations(file.skin.elements, file.skin.spacing, file.skin.grading)
        mesh = mesh_curve(skin.position(arc_lengths))
    with at_key(path, "section.thickness"):
        for text in slenderness(skin, arc_lengths, file.section.thickness):
            if remark is not None:
                remark(f"{path.name}: {text}")
    with at_key(path, "airfoil.target"):
        positions = skin.target_positions(target, arc_lengths)
    return Geometry(skin, arc_lengths, mesh, positions, contour.outline, target.outline)


@contextmanager
def at_key(path: Path, key: str) -> Iterator[None]:
    """Say in which file and at which of its keys an input error arose."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{str(path)!r}, {key}: {error}") from error


def _contour(path: Path, file: SkinFile, remark: Remark | None) -> Contour:
    units, chord = file.airfoil.units, file.airfoil.chord
    in_file_units = chord * _METRES[file.units] / _METRES[units] if units in _METRES else None
    airfoil = read_airfoil(path, units, in_file_units)
    for text in (*airfoil.repairs, *airfoil.warnings):
        if remark is not None:
            remark(f"{path.name}: {text}")
    return Contour.through(airfoil.points, chord)


def _cut(path: Path, file: SkinFile, contour: Contour) -> Skin:
    with at_key(path, "skin.start"):
        start = contour.at_x(file.skin.start.x, file.skin.start.side)
    with at_key(path, "skin.end"):
        end = contour.at_x(file.skin.end.x, file.skin.end.side)
    with at_key(path, "skin.start, skin.end"):
        return Skin(contour, start, end)
