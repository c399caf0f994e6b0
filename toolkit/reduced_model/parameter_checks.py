"""Values of a reduced model's parameters that no body has: formulas of the file would go on with them without a word."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from toolkit.foundation.errors import InputError

TINY = np.finfo(float).tiny
LEAST = {
    "youngs_modulus": TINY, "density": TINY, "thickness": TINY, "width": TINY, "chord": TINY, "y_scale": TINY, "damping": 0.0,
    "diameter": TINY, "wall": TINY, "area": TINY, "I_y": TINY, "I_z": TINY, "I_p": TINY, "J": TINY,
}  # fmt: skip
"""Least value of parameters of reduced models by the beginnings of their names; others, such as the height of a bump, have none."""
SWAPPED = 1.2
"""Ratio of the sides of a rectangle up to which the formula for its torsion, which knows the shorter one at the nominal design, is right
to 0.4 % where this one has become the longer."""


def check_parameters(values: Mapping[str, Any], nominal: Mapping[str, float], where: str, dimension: int) -> None:
    """Refuse sizes and material constants that no body can have.

    Parameters
    ----------
    values, nominal
        Parameter -> what the scene sets, and what all of the reduced model have.
    where
        Path of the body in the scene, for the text.
    dimension
        Of space.

    Raises
    ------
    InputError
        Names the parameter and what would be right.
    """
    real = {name: float(np.real(value)) for name, value in values.items()}
    for name, value in real.items():
        least = LEAST.get(next((known for known in LEAST if name.startswith(known)), ""), -np.inf)
        if not value > 0 and (least > 0 or value < least) and nominal.get(name, 1.0) >= least:
            raise InputError(f"{where}.{name} = {value:g} must be {'a positive number' if least > 0 else 'zero or positive'}.")
        if name.startswith("poisson_ratio") and not -1 < value < 0.5:
            raise InputError(f"{where}.{name} = {value:g} must be above -1 and below 0.5.")
    here = {**nominal, **real}
    for wall, diameter in _mates(real, here, "wall", "diameter"):
        if 2 * here[wall] > here[diameter] * (1 + 1e-12):  # a full bar, written with decimals
            raise InputError(
                f"{where}: a {wall} of {here[wall]:g} is more than half the {diameter} of {here[diameter]:g}: no tube has that. "
                "Make the wall thinner, or the tube wider."
            )
    for thickness, width in _mates(real, here, "thickness", "width") if dimension == 3 else ():
        sides, built = (each[thickness] / each[width] for each in (here, {**here, **nominal}))
        if (sides if built <= 1 else 1 / sides) > SWAPPED:
            raise InputError(
                f"{where}: with {thickness} = {here[thickness]:g} and {width} = {here[width]:g} the side is the longer one that was "
                f"the shorter when the reduced model was built ({nominal[thickness]:g} and {nominal[width]:g}); its formula for torsion "
                "does not reach so far. Build it anew with these numbers."
            )


def _mates(changed: Mapping[str, float], all_of: Mapping[str, float], one: str, other: str) -> Iterator[tuple[str, str]]:
    """Pairs of parameters of one section or group, of which the scene sets one; a group without its own has the body's."""
    suffixes = {name.removeprefix(kind) for name in all_of for kind in (one, other) if name.startswith(kind)}
    for suffix in sorted(suffixes):
        pair = tuple(kind + suffix if kind + suffix in all_of else kind for kind in (one, other))
        if all(name in all_of for name in pair) and any(name in changed for name in pair):
            yield pair[0], pair[1]
