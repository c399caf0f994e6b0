"""The design variables of the skin's shape: chord, y_scale, and the heights of the modes that skin.toml names."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from preprocessing.skin_file import SkinFile

TAKEN = (
    "youngs_modulus", "density", "thickness", "width", "poisson_ratio", "damping_mass", "damping_stiffness", "chord", "y_scale",
    "type", "model", "frame", "position", "angle", "velocity", "angular_velocity", "extrapolation",
)  # fmt: skip
"""Names of the other parameters that a reduced model can have, and keys of a flexible body in a scene."""

TAKEN_PREFIXES = ("thickness_", "width_", "youngs_modulus_", "density_", "damping_mass_", "damping_stiffness_", "arc_length_")
"""Beginnings of the names of parameters of element groups and interface points."""


def mode_name(name: str) -> str:
    """The name itself; it becomes that of a parameter, of a group in an HDF5 file, and part of paths in which dots separate.

    Raises
    ------
    ValueError
        It cannot be one of these, or is that of another parameter.
    """
    if not name.strip() or set(name) & set("./\0"):
        raise ValueError("this is no legal name of a shape mode; use letters, digits and _")
    if name in TAKEN:
        raise ValueError(f"a shape mode cannot have the name of another parameter ({', '.join(TAKEN)}); choose another name")
    if name.startswith(TAKEN_PREFIXES):
        raise ValueError(
            f"a shape mode's name cannot begin like those of element groups ({', '.join(TAKEN_PREFIXES)}); choose another name"
        )
    return name


def shape_parameters(file: SkinFile) -> dict[str, float]:
    """Nominal values by name, the modes in the order of the file.

    Airfoil files in mm or m hold lengths, which the chord only checks: nothing depends on it, and it is left out.
    """
    chord = {} if file.airfoil.units in ("mm", "m") else {"chord": float(file.airfoil.chord)}
    modes = {name: float(mode.height) for name, mode in file.shape.items()}
    return {**chord, "y_scale": float(file.airfoil.y_scale), **modes}
