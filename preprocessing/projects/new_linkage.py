"""A linkage of one's own: a crank-rocker with a motor and a spring, in one of the systems of units."""

from __future__ import annotations

import shlex
from pathlib import Path

from preprocessing.projects.new_folder import refuse_occupied, substituted, write_folder
from preprocessing.projects.texts import README, SCENE, STUDY
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import UNIT_SYSTEMS

METRES = {"O": (0.0, 0.0), "A": (0.0, 0.04), "B": (0.11, 0.09), "C": (0.11, 0.0)}
"""Places of the joints: crank 40 mm, coupler 121 mm, rocker 90 mm, ground 110 mm. The shortest and the longest are together shorter
than the others, so that the crank turns fully (Grashof)."""
BESIDE = 0.01
"""Distance in m by which the study may move B."""
STIFFNESS, DAMPING = 0.5, 0.005
"""Stiffness and damping of the spring at the rocker, in N m/rad and N m s/rad."""
WORDS = {
    "mm-t-s": "Lengths in mm, masses in t, times in s; forces in N, torques in N mm.",
    "m-kg-s": "Lengths in m, masses in kg, times in s; forces in N, torques in N m.",
}
PER_METRE = {"mm-t-s": 1000.0, "m-kg-s": 1.0}
"""Units of length in a metre; torques count in as many parts of a newton metre."""
PER_KILOGRAM = {"mm-t-s": 1e-3, "m-kg-s": 1.0}


def new_linkage(folder: str | Path, units: str = "mm-t-s") -> list[Path]:
    """Write a folder with scene.toml, study.toml and README.md.

    Parameters
    ----------
    folder : new, or empty
    units : name of the system of units

    Raises
    ------
    InputError
        The folder is not empty or cannot be written, or there are no such units.
    """
    refuse_units(units)
    refuse_occupied(folder := Path(folder))
    length, mass = PER_METRE[units], PER_KILOGRAM[units]
    x, y = METRES["B"]
    numbers = {
        **{name: _list(*(length * each for each in place)) for name, place in METRES.items()},
        "units": units, "words": WORDS[units], "area": _short(6e-5 * length**2), "density": _short(7850 * mass / length**3),
        "stiffness": _short(STIFFNESS * length), "damping": _short(DAMPING * length), "gravity": _short(9.81 * length),
        "x_B": _list(length * (x - BESIDE), length * (x + BESIDE)), "y_B": _list(length * (y - BESIDE), length * (y + BESIDE)),
        "k": _list(STIFFNESS * length / 2, 2 * STIFFNESS * length), "higher": f"{1.05 * y * length:g}", "folder": shlex.quote(str(folder)),
    }  # fmt: skip
    return write_folder(folder, substituted({"scene.toml": SCENE, "study.toml": STUDY, "README.md": README}, numbers))


def refuse_units(units: str) -> None:
    """Refuse systems of units that no scene has."""
    if units not in UNIT_SYSTEMS:
        raise InputError(f"there are no units {units!r}. Take one of {', '.join(UNIT_SYSTEMS)}.")


def _short(number: float) -> float:
    return float(f"{number:.6g}")


def _list(*numbers: float) -> str:
    return str([_short(number) for number in numbers])
