"""A morphing wing of one's own from any airfoil file: skin and linkage of the reference wing, fitted into another section."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from preprocessing.airfoil.airfoil import read_airfoil
from preprocessing.curve.contour import Contour
from preprocessing.curve.skin import Skin
from preprocessing.recipes.skin.droop import drooped
from preprocessing.wings.texts import README, SCENE, SKIN, STUDY
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.replaced_file import write_whole

REFERENCE_CHORD = 550.0
"""Chord of the reference wing in mm; a wing of another chord is a scaled copy, with the same stresses."""

CHORDS = 1e-3, 1e6
"""mm; the shortest and the longest that is meant: the torque goes with the cube of it."""

CLAMP = 0.25
"""Place of F and G along the chord."""

DROOP = 6.0 / 550.0
"""Depth in chords of the droop that is the target if none is given, as in the reference wing."""

LINKAGE = {"A": (72.5 / 550, 0.42214), "B": (75.3 / 550, 0.15679), "D": (61.8 / 550, 0.47488)}
"""Joints of the reference wing: place along the chord, and height as a part of the section's thickness there."""

TORQUES, THICKNESSES = (0.6, 1.5), (0.8, 5 / 3)
"""Bounds of the study, in parts of what the scene has."""
ALONG, ACROSS, BESIDE = 0.01, 0.15, 0.02
"""How far the study may move joints: along the chord in parts of it, and in height in parts of the section's thickness there; of which so
much is left beside the skin, wherever along the chord the joint is moved to."""


@dataclass(frozen=True)
class Section:
    """The section of the new wing, in mm."""

    contour: Contour
    skin: Skin
    chord: float

    @classmethod
    def of(cls, airfoil: Path, chord: float) -> Section:
        """Read the airfoil and cut its skin at F and G."""
        contour = Contour.through(read_airfoil(airfoil).points, chord)
        start, end = (contour.at_x(CLAMP * chord, side) for side in ("upper", "lower"))
        return cls(contour, Skin(contour, start, end), chord)

    def joint(self, along: float, height: float) -> list[float]:
        """Place of a joint of the linkage."""
        x = along * self.chord
        lower, upper = (self.contour.position(self.contour.at_x(x, side))[1] for side in ("lower", "upper"))
        return [float(f"{number:.5g}") for number in (x, lower + height * (upper - lower))]


def new_wing(
    folder: str | Path, airfoil: str | Path, target: str | Path | None = None, chord: float = REFERENCE_CHORD
) -> list[Path]:
    """Write a folder with airfoil.dat, target.dat, skin.toml, scene.toml, study.toml and README.md.

    Parameters
    ----------
    folder : new, or empty
    airfoil, target : airfoil files in fractions of the chord and in one frame; without a target the nose droops by 1.1 % of the chord
    chord : mm

    Raises
    ------
    InputError
        The folder is not empty or cannot be written, an airfoil is missing or unreadable, or the two do not fit together.
    """
    if not CHORDS[0] <= chord <= CHORDS[1]:
        raise InputError(
            f"a chord of {chord:g} mm cannot be. Give a length from {CHORDS[0]:g} to {CHORDS[1]:g} mm, for example --chord 550."
        )
    folder, airfoil, target = Path(folder), Path(airfoil), None if target is None else Path(target)
    _refuse_occupied(folder)
    section = Section.of(airfoil, chord)
    content = {
        "airfoil.dat": airfoil.read_bytes(),
        "target.dat": _target(section, target),
        **_texts(section, folder, airfoil, target),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, data in content.items():
            write_whole(folder / name, data)
    except OSError as error:
        raise InputError(f"{str(folder)!r} cannot be written ({error.strerror}). Name another folder.") from error
    return [folder / name for name in content]


def _refuse_occupied(folder: Path) -> None:
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        what = "is not empty" if folder.is_dir() else "is a file"
        raise InputError(f"{str(folder)!r} {what}, and nothing of yours shall be overwritten. Name a new folder.")


def _target(section: Section, path: Path | None) -> bytes:
    """The target's file, if it fits to the skin; or a droop of the nose."""
    if path is not None:
        contour = Contour.through(read_airfoil(path).points, section.chord)
        section.skin.target_positions(contour, np.linspace(0, section.skin.length, 31))
        return path.read_bytes()
    rows = drooped(section.contour, section.skin, DROOP * section.chord, section.chord) / section.chord
    lines = [f"nose drooped by {DROOP:.2%} of the chord", *(f" {x:.9f} {y:.9f}" for x, y in rows)]
    return ("\n".join(lines) + "\n").encode()


def _texts(section: Section, folder: Path, airfoil: Path, target: Path | None) -> dict[str, bytes]:
    """Skin, scene and README; all lengths go with the chord, the torque with its cube: the stresses stay."""
    scale = section.chord / REFERENCE_CHORD
    torque = float(f"{4200 * scale**3:.4g}")
    numbers = {
        "chord": section.chord, "clamp_x": CLAMP * section.chord, "thickness": 1.5 * scale, "width": 1000 * scale,
        "area": 100 * scale**2, "torque": torque, **{name: section.joint(*place) for name, place in LINKAGE.items()},
    }  # fmt: skip
    words = {
        "name": f"`{airfoil.name}`", "folder": shlex.quote(str(folder)), "more": f"{1.1 * torque:g}",
        "target": f"`{target.name}`" if target else f"here the nose drooped by {DROOP:.1%} of the chord, in place of a target of your own",
    }  # fmt: skip
    texts = {
        "skin.toml": SKIN.substitute(numbers),
        "scene.toml": SCENE.substitute(numbers),
        "study.toml": STUDY.substitute(_bounds(section, torque, 1.5 * scale)),
        "README.md": README.substitute(words),
    }
    return {name: text.encode() for name, text in texts.items()}


def _bounds(section: Section, torque: float, thickness: float) -> dict[str, str]:
    """What the study may change, and how far."""
    lines = []
    for name, (along, height) in LINKAGE.items():
        (x, y), chord = section.joint(along, height), section.chord
        ends = (along - ALONG, along + ALONG)
        lowest = max(section.joint(along, height - ACROSS)[1], *(section.joint(end, BESIDE)[1] for end in ends))
        highest = min(section.joint(along, height + ACROSS)[1], *(section.joint(end, 1 - BESIDE)[1] for end in ends))
        lines += [
            f'"points.{name}.x" = {{ between = {_between(x - ALONG * chord, x + ALONG * chord)} }}',
            f'"points.{name}.y" = {{ between = {_between(min(lowest, y), max(highest, y))} }}',
        ]
    return {
        "M_t": _between(*(part * torque for part in TORQUES)),
        "t_w": _between(*(part * thickness for part in THICKNESSES)),
        "joints": "\n".join(lines),
    }


def _between(low: float, high: float) -> str:
    return str([float(f"{number:.5g}") for number in (low, high)])
