"""The geometry of one skin: both airfoils read, F and G found, the curve cut and meshed, the target matched.

The mesh is made once. At other values of the shape parameters its nodes move along with the curve, which gives dX/dx of all that
is made of them: every step from the rows of the airfoil files to the nodes takes complex values, so that a complex step in one
parameter gives derivatives exact to round-off. They are those of a new preprocessing with that one key of skin.toml changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from preprocessing.airfoil.airfoil import read_airfoil
from preprocessing.curve.bump import Bump, bumped
from preprocessing.curve.contour import Contour
from preprocessing.curve.skin import Skin
from preprocessing.discretisation.slenderness import slenderness
from preprocessing.input.at_key import at_key
from preprocessing.mesh.curve_mesh import CurveMesh, mesh_curve
from preprocessing.recipes.recipe import Remark
from preprocessing.recipes.skin.shape_parameters import shape_parameters
from preprocessing.recipes.skin.skin_file import ShapeMode, SkinFile
from toolkit.foundation.errors import InputError


@dataclass(frozen=True)
class Contours:
    """Contours of the undeformed section and the wanted one."""

    airfoil: Contour
    target: Contour

    def shaped(self, path: Path, file: SkinFile, design: Mapping[str, complex]) -> Contours:
        """The contours at a design, from those at the chord of the file, with y_scale 1 and without bumps.

        Parameters
        ----------
        design : values of all `shape_parameters`

        Raises
        ------
        InputError
            A bump does not fit on a contour, or its place is not there; names the file and the mode.
        """
        stretch = design.get("chord", file.airfoil.chord) / file.airfoil.chord
        y_scale = design["y_scale"]
        plain = Contours(*(contour.stretched(stretch, stretch * y_scale) for contour in (self.airfoil, self.target)))
        return plain._bumped(path, file, design) if file.shape else plain

    def _bumped(self, path: Path, file: SkinFile, design: Mapping[str, complex]) -> Contours:
        with at_key(path, "skin.start"):
            f = self.airfoil.at_x(file.skin.start.x, file.skin.start.side)
        origins = {"airfoil": f, "target": self.target.nearest(self.airfoil.position(f))}
        shaped = {}
        for which, origin in origins.items():
            contour, bumps = getattr(self, which), []
            for name, mode in file.shape.items():
                with at_key(path, f"shape.{name}"):
                    if mode.of in (which, "both"):
                        bumps.append(_bump(contour, mode, origin, design[name]))
            with at_key(path, "shape modes"):
                shaped[which] = bumped(contour, bumps)
        return Contours(**shaped)


def _bump(contour: Contour, mode: ShapeMode, origin: complex, height: complex) -> Bump:
    """The bump of a mode on one contour, on which arc lengths from F begin at `origin`."""
    if mode.arc_length is not None:
        centre = origin + mode.arc_length
    else:
        assert mode.x is not None
        assert mode.side is not None
        centre = contour.at_x(mode.x, mode.side)
    return Bump(centre, mode.half_width, height).checked(contour)


__all__ = ["Geometry", "at_key", "read_geometry", "shape_parameters"]

_METRES = {"mm-t-s": 1e-3, "m-kg-s": 1.0, "mm": 1e-3, "m": 1.0}
"""Metres per unit of length of the unit systems and of airfoil files."""


@dataclass(frozen=True)
class Source:
    """Contents from which a geometry is constructed at any design."""

    path: Path  # of skin.toml
    file: SkinFile
    contours: Contours  # through the rows of both files, at the chord of the file


@dataclass(frozen=True)
class Geometry:
    """Skin, its nodes and their target places, in the units of skin.toml; complex where a complex step is taken."""

    source: Source
    skin: Skin
    arc_lengths: np.ndarray  # (n_nodes,) from F along the true curve
    mesh: CurveMesh
    target_contour: Contour
    target: np.ndarray  # (n_nodes, 2)

    @property
    def outline(self) -> np.ndarray:
        """Points (n_points, 2) to draw the section by, real."""
        return self.skin.contour.outline

    @property
    def target_outline(self) -> np.ndarray:
        """Points (n_points, 2) to draw the target by, real."""
        return self.target_contour.outline

    def moved(self, values: Mapping[str, complex]) -> Geometry:
        """The geometry at other values of shape parameters, with the connectivity of this mesh.

        Interface points are located on it as on the nominal one: `skin.locate(..., stations=arc_lengths)`.

        Parameters
        ----------
        values : name -> value
            Real or complex, of some of `shape_parameters`; the others keep the values of skin.toml.

        Raises
        ------
        InputError
            Unknown parameter, a chord or scale that is not positive, a shape that cannot be constructed, or a complex step
            together with nodes spaced by curvature.
        """
        return _constructed(self.source, values, lambda stations: replace(self.mesh, nodes=stations))


def read_geometry(path: Path, file: SkinFile, remark: Remark | None = None) -> Geometry:
    """Geometry of the skin that skin.toml (at `path`, content `file`) describes.

    `remark` is called with every repair of an airfoil file and every warning about it or the thickness, in words.

    Raises
    ------
    InputError
        An airfoil file cannot be used, or F, G, a shape mode, the thickness or the target do not fit to it; names the file and
        the key.
    """
    with at_key(path, "airfoil.file"):
        contour = _contour(path.parent / file.airfoil.file, file, file.airfoil.units, remark)
    with at_key(path, "airfoil.target"):
        target = _contour(path.parent / file.airfoil.target, file, file.airfoil.target_units or file.airfoil.units, remark)
    geometry = _constructed(Source(path, file, Contours(contour, target)), {}, mesh_curve)
    with at_key(path, "section.thickness"):
        for text in slenderness(geometry.skin, geometry.arc_lengths, file.section.thickness):
            if remark is not None:
                remark(f"{path.name}: {text}")
    return geometry


def _constructed(source: Source, values: Mapping[str, complex], mesh_of: Callable[[np.ndarray], CurveMesh]) -> Geometry:
    path, file = source.path, source.file
    contours = source.contours.shaped(path, file, _design(source, values))
    skin = _cut(path, file, contours.airfoil)
    with at_key(path, "skin"):
        arc_lengths = skin.stations(file.skin.elements, file.skin.spacing, file.skin.grading)
        mesh = mesh_of(skin.position(arc_lengths))
    with at_key(path, "airfoil.target"):
        target = skin.target_positions(contours.target, arc_lengths)
    return Geometry(source, skin, arc_lengths, mesh, contours.target, target)


def _design(source: Source, values: Mapping[str, complex]) -> dict[str, complex]:
    """Values of all shape parameters."""
    nominal = shape_parameters(source.file)
    for name, value in values.items():
        if name not in nominal:
            lengths = source.file.airfoil.in_lengths if name == "chord" else []
            why = f"; the airfoil files are in {' and '.join(lengths)}, and no chord scales them" if lengths else ""
            raise InputError(f"{name!r} is no shape parameter of {str(source.path)!r}; available: {', '.join(nominal)}{why}.")
        if not np.isfinite(value) or (name in ("chord", "y_scale") and np.real(value) <= 0):
            raise InputError(
                f"the shape parameter {name!r} cannot be {value!r}: give a finite number, above 0 for a chord or scale."
            )
    return {**nominal, **values}


def _contour(path: Path, file: SkinFile, units: str | None, remark: Remark | None) -> Contour:
    chord = file.airfoil.chord
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
