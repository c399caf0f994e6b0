"""The design variables of the skin's shape: chord, y_scale, and the heights of the modes that skin.toml names."""

from __future__ import annotations

from preprocessing.recipes.skin.skin_file import SkinFile


def shape_parameters(file: SkinFile) -> dict[str, float]:
    """Nominal values by name, the modes in the order of the file.

    Airfoil files in mm or m hold lengths, which the chord only checks: nothing depends on it, and it is left out.
    """
    chord = {} if file.airfoil.in_lengths else {"chord": float(file.airfoil.chord)}
    modes = {name: float(mode.height) for name, mode in file.shape.items()}
    return {**chord, "y_scale": float(file.airfoil.y_scale), **modes}
