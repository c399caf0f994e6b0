"""Names that modes of the skin's shape can have."""

from __future__ import annotations

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
