"""Both contours of a skin at any values of its shape parameters, real or complex.

The splines through the rows of the files and their parametrisations stay. In this order the chord stretches both contours, y_scale
their y, and the bumps displace them; places and lengths of the bumps are those of skin.toml, on the stretched contours.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from preprocessing.curve.bump import Bump, bumped
from preprocessing.curve.contour import Contour
from preprocessing.input.at_key import at_key
from preprocessing.recipes.skin.skin_file import ShapeMode, SkinFile


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
