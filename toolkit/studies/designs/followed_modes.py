"""Frequencies of modes that are recognised by their shapes, so that a study sees the same vibration where others cross it.

The mode of a number is the one of that number where the scene stands. At another design it is the one that is most alike, by the mode
assurance of shapes u and r,

    |r^H M u|^2 / (r^H M r  u^H M u)

Shapes of modes are orthogonal by the mass M, so that of the assurances of all modes with r at most one is above one half.
"""

from __future__ import annotations

import numpy as np

from toolkit.analyses.modes import solve_modes
from toolkit.foundation.errors import InputError, ToolkitError
from toolkit.responses.vibrations.pencil import pencil_of
from toolkit.responses.vibrations.vibration import Frequency
from toolkit.system.solution import Solution

ALIKE = 0.5
"""Assurance above which a mode is the one."""
AGREE = 1e-6
"""Relative difference of a frequency by the two ways in which it is found."""


class LostModeError(ToolkitError, ArithmeticError):
    """No mode of a design is the one that is followed."""


def shapes_of(solution: Solution, count: int) -> np.ndarray:
    """The slowest modes of the scene as it stands, (n_q, count).

    Raises
    ------
    InputError
        There are not so many.
    """
    found = solve_modes(solution)
    if len(found.frequencies) < count:
        raise InputError(f"frequency_{count}: the scene has {len(found.frequencies)} modes. Ask for one of these.")
    return found.shapes[:, :count]


def followed(solution: Solution, shapes: np.ndarray, number: int) -> Frequency:
    """The frequency of the mode of an equilibrium that is most like that of a number among the shapes.

    Raises
    ------
    LostModeError
        None of them is like it any more.
    """
    mass = np.real(pencil_of(solution).mass[: solution.system.n_q, : solution.system.n_q])
    modes, reference = solve_modes(solution), shapes[:, number - 1]
    squares = np.real(np.einsum("ik,ij,jk->k", modes.shapes.conj(), mass, modes.shapes))  # complex are those that flutter
    alike = np.abs(reference.conj() @ mass @ modes.shapes) ** 2 / (squares * np.real(reference.conj() @ mass @ reference))
    k = int(np.argmax(alike))
    remedy = f'ask for frequencies by their order, with a response {{ type = "frequency", number = {number} }}'
    if alike[k] <= ALIKE:
        raise LostModeError(
            f"frequency_{number}: no mode is like the one that has this number where the scene stands. Number {k + 1} is most like it, "
            f"with an assurance of {alike[k]:.2g}, and more than {ALIKE:g} is wanted. Narrow the bounds, or {remedy}."
        )
    found, value = Frequency(number=k + 1), float(modes.frequencies[k])
    if abs(float(np.real(found.value(solution))) - value) > AGREE * abs(value):
        raise LostModeError(
            f"frequency_{number}: modes without stiffness cannot be told from others. Hold what moves freely, or {remedy}."
        )
    return found
