"""The geometry of one skin: airfoils, F and G, the meshed curve and its target; and whether the skin is thin enough for beams.

A target shape for a skin that has none: the same skin with its nose drooped, without stretching it anywhere.

The droop is a change of curvature of the material line, so that every point keeps its arc length from F. With tau = s / L,

    dk(tau) = w(tau) / L [c_0 + c_1 cos(pi tau) + c_2 cos(2 pi tau)],   w = S(tau / 0.1) S((1 - tau) / 0.1),   S(q) = q^2 (3 - 2 q)
    dtheta(s) = int_0^s dk ds,   r_1(s) = r_0(s) + int_0^s [(cos, sin)(theta_0 + dtheta) - (cos, sin)(theta_0)] ds

and c such that slope and height at G stay, and the leading edge sinks by the wanted depth.

The mesh is made once. At other values of the shape parameters its nodes move along with the curve, which gives dX/dx of all that
is made of them: every step from the rows of the airfoil files to the nodes takes complex values, so that a complex step in one
parameter gives derivatives exact to round-off. They are those of a new preprocessing with that one key of skin.toml changed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.optimize import fsolve

from preprocessing.airfoil.airfoil_file import read_airfoil
from preprocessing.airfoil.contour import Bump, Contour, bumped
from preprocessing.airfoil.skin import Skin
from preprocessing.builders.curve_mesh import CurveMesh, mesh_curve
from preprocessing.builders.recipe import Remark
from preprocessing.builders.skin_file import ShapeMode, SkinFile, shape_parameters
from preprocessing.mesh.input_files import at_key
from toolkit.foundation.errors import InputError

SAMPLES = 2001
"""Arc lengths along the skin at which the integrals are taken; errors of Simpson's rule are far below the rows' last digit."""

TARGET_ROWS = 161
"""Rows of the target between F and G: close enough for a spline to follow any nose."""

CLOSING_PART = 0.15
"""Behind G the lower side returns to the undeformed one within this part of the chord."""


def drooped(contour: Contour, skin: Skin, depth: float, chord: float) -> np.ndarray:
    """Rows (n, 2) of the contour with its nose sunk by `depth`, trailing edge, upper side, nose, lower side.

    Parameters
    ----------
    contour, skin : the undeformed section and its skin
    depth : how far the leading edge sinks, in the unit of the contour

    Raises
    ------
    InputError
        No such droop exists; it is too deep for this section.
    """
    s = np.linspace(0, skin.length.real, SAMPLES)
    place, angle, nose = skin.position(s), skin.tangent_angle(s), contour.leading_edge - skin.start.real

    def moved(c: np.ndarray) -> tuple[np.ndarray, float]:
        turn = cumulative_simpson(_change(s / skin.length, c) / skin.length, x=s, initial=0)
        pairs = ((np.cos, 0), (np.sin, 1))
        shift = [cumulative_simpson(f(angle + turn) - f(angle), x=s, initial=0) for f, _ in pairs]
        return place + np.stack(shift, axis=1), turn[-1]

    def misses(c: np.ndarray) -> list[float]:
        line, slope = moved(c)
        sunk = np.interp(nose, s, line[:, 1] - place[:, 1])
        return [slope, (line[-1, 1] - place[-1, 1]) / depth, sunk / depth + 1]

    c, _, found, _ = fsolve(misses, np.array([0.0, 50 * depth / chord * 0.5, 0.0]), full_output=True)
    if found != 1:
        raise InputError(f"the nose cannot droop by {depth:g} with slope and height kept at G. Choose a smaller depth.")
    line, _ = moved(c)
    return _completed(contour, skin, line[:: (SAMPLES - 1) // (TARGET_ROWS - 1)], chord)


def _change(tau: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Change of curvature L dk at tau = s / L."""
    window = _step(tau / 0.1) * _step((1 - tau) / 0.1)
    return window * (c[0] + c[1] * np.cos(np.pi * tau) + c[2] * np.cos(2 * np.pi * tau))


def _step(q: np.ndarray) -> np.ndarray:
    q = np.clip(q, 0, 1)
    return q * q * (3 - 2 * q)


def _completed(contour: Contour, skin: Skin, line: np.ndarray, chord: float) -> np.ndarray:
    """The moved skin between the rows before F and those behind G, which follow G's slide and fade out of it."""
    rows, at = contour.position(contour.curve.point_s), contour.curve.point_s
    gap = 0.5 * skin.length / TARGET_ROWS
    before, behind = rows[at < skin.start - gap], rows[at > skin.end + gap].copy()
    slide = line[-1] - skin.position(skin.length)
    behind += slide * (1 - _step((behind[:, :1] - skin.position(skin.length)[0]) / (CLOSING_PART * chord)))
    return np.vstack([before, line, behind])


SHORTEST_ELEMENT = 0.2  # thicknesses; finer elements resolve nothing that Euler-Bernoulli beams describe
THINNEST_SKIN = 1e-6  # skin lengths L; bending over stretching stiffness is (t / L)^2, and 1e-16 is round-off


def slenderness(skin: Skin, arc_lengths: np.ndarray, thickness: float) -> tuple[str, ...]:
    """Warnings about a skin too thick for Euler-Bernoulli beams along its curve, in words.

    Parameters
    ----------
    arc_lengths : (n_nodes,) of the nodes from F; like `thickness` in the unit of the skin's length

    Raises
    ------
    InputError
        The bending stiffness would be lost in the round-off of the stretching stiffness.
    """
    if thickness < THINNEST_SKIN * skin.length.real:
        raise InputError(
            f"a thickness of {thickness:g} is less than {THINNEST_SKIN:g} of the skin's length {skin.length:g}: its bending stiffness "
            "would be lost in round-off. Fix the exponent or the units."
        )
    samples = np.linspace(0.0, skin.length, 2000)
    radius = 1 / np.abs(skin.curvature(samples)).max()
    shortest = float(np.diff(arc_lengths).min())
    warnings = []
    if thickness / 2 > radius:
        warnings.append(
            f"half the thickness ({thickness / 2:.3g}) exceeds the smallest radius of curvature of the skin ({radius:.3g}): "
            "the inner fibre would fold there, stresses mean nothing"
        )
    if shortest < SHORTEST_ELEMENT * thickness:
        warnings.append(
            f"the thickness ({thickness:.3g}) exceeds the shortest element ({shortest:.3g}) {thickness / shortest:.3g} times: "
            "Euler-Bernoulli beams are thin; take fewer elements or a thinner skin"
        )
    return tuple(warnings)


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
class SkinSource:
    """Contents from which a geometry is constructed at any design."""

    path: Path  # of skin.toml
    file: SkinFile
    contours: Contours  # through the rows of both files, at the chord of the file


@dataclass(frozen=True)
class Geometry:
    """Skin, its nodes and their target places, in the units of skin.toml; complex where a complex step is taken."""

    source: SkinSource
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
    geometry = _constructed(SkinSource(path, file, Contours(contour, target)), {}, mesh_curve)
    with at_key(path, "section.thickness"):
        for text in slenderness(geometry.skin, geometry.arc_lengths, file.section.thickness):
            if remark is not None:
                remark(f"{path.name}: {text}")
    return geometry


def _constructed(source: SkinSource, values: Mapping[str, complex], mesh_of: Callable[[np.ndarray], CurveMesh]) -> Geometry:
    path, file = source.path, source.file
    contours = source.contours.shaped(path, file, _design(source, values))
    skin = _cut(path, file, contours.airfoil)
    with at_key(path, "skin"):
        arc_lengths = skin.stations(file.skin.elements, file.skin.spacing, file.skin.grading)
        mesh = mesh_of(skin.position(arc_lengths))
    with at_key(path, "airfoil.target"):
        target = skin.target_positions(contours.target, arc_lengths)
    return Geometry(source, skin, arc_lengths, mesh, contours.target, target)


def _design(source: SkinSource, values: Mapping[str, complex]) -> dict[str, complex]:
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
