"""Whether a skin is thin enough for the beams that it is made of, and thick enough to have a bending stiffness at all."""

from __future__ import annotations

import numpy as np

from preprocessing.curve.skin import Skin
from toolkit.foundation.errors import InputError

SHORTEST_ELEMENT = 0.2  # thicknesses; finer elements resolve nothing that Euler-Bernoulli beams describe
THINNEST = 1e-6  # skin lengths L; bending over stretching stiffness is (t / L)^2, and 1e-16 is round-off


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
    if thickness < THINNEST * skin.length:
        raise InputError(
            f"a thickness of {thickness:g} is less than {THINNEST:g} of the skin's length {skin.length:g}: its bending stiffness "
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
