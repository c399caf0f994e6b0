"""Numbers, units, colours and views that pictures share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.model_body import ModelBody
from toolkit.foundation.errors import InputError
from toolkit.foundation.units import unit
from toolkit.responses.stress import point_stress, stress_components
from toolkit.scene.resolution import ResolvedScene
from toolkit.scene.scene import Scene
from toolkit.system.solution import Solution, elastic_coordinates, flexible_body

UNDEFORMED, TARGET, ROD, SUPPORT = "#707070", "#1a8f3c", "#8fa3bf", "#7a4a1e"
INK, FRAME, BODY = "#202020", "#808080", "#3d5478"


MINUS = "\N{MINUS SIGN}"
"""Minus sign as axes write it."""


def round_up(value: float) -> float:
    """Next larger number with a short decimal form that can be halved; zero stays zero."""
    if value == 0:
        return 0.0
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(power * digit for digit in (1, 1.2, 1.6, 2, 2.4, 3, 4, 5, 6, 8, 10) if power * digit >= value))


def even(value: float, finest: float) -> str:
    """A number with as many decimals as it takes to show `finest`, however large it is itself; in powers of ten if those are many."""
    decimals = max(0, -int(np.floor(np.log10(finest))))
    return f"{round(value, decimals) + 0.0:.{decimals}f}" if decimals < 6 and finest < 1e3 else f"{value:.2e}"


def tick_step(least: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is not less than a length."""
    power = 10.0 ** np.floor(np.log10(least))
    return float(next(power * digit for digit in (1, 2, 5, 10) if power * digit >= least * (1 - 1e-9)))


_LADDERS = (
    {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
    {"N": 1.0, "kN": 1e3, "MN": 1e6},
    {"N mm": 1e-3, "N m": 1.0, "kN m": 1e3, "MN m": 1e6},
    {"mJ": 1e-3, "J": 1.0, "kJ": 1e3, "MJ": 1e6},
    {"mW": 1e-3, "W": 1.0, "kW": 1e3, "MW": 1e6},
    {"mm": 1e-3, "m": 1.0},
)
"""Units of one quantity, from the smallest to the largest."""
_LEAST, _MOST = 1e-2, 1e4
"""Sizes between which a number is short in its own unit."""


class Readable(NamedTuple):
    """Factor by which numbers are multiplied for a picture, and the label of their unit then."""

    factor: float
    label: str


def readable(largest: float, label: str) -> Readable:
    """Unit in which numbers are written in a picture.

    Parameters
    ----------
    largest : float
        Size of the largest of the numbers, not negative.
    label : str
        Of their own unit; one that has no neighbours stays.

    Returns
    -------
    factor, label : Readable
        The own unit where the largest number is short in it; else the largest unit in which it is not below 1.
    """
    ladder = next((each for each in _LADDERS if label in each), {})
    if not ladder or not np.isfinite(largest) or largest == 0 or _LEAST <= largest < _MOST:
        return Readable(1.0, label)
    size = largest * ladder[label]
    chosen = max(
        (name for name in ladder if ladder[name] <= size), key=ladder.__getitem__, default=min(ladder, key=ladder.__getitem__)
    )
    return Readable(ladder[label] / ladder[chosen], chosen)


def readable_stress(limit: float, units: str) -> Readable:
    """Readable unit for stresses up to a limit, in a system of units."""
    return readable(limit, unit(units, "stress"))


STRAIN = 1e-11
"""A strain that is round-off: displacements have 16 digits, of which differences of neighbours lose some."""
_AT_ONCE = 256
"""Instants whose stress is in memory together."""


def stress_range(solution: Solution, body: str, steps: slice = slice(None)) -> np.ndarray:
    """Smallest and largest stress of a flexible body at every time, (n_t, 2); zero where it is round-off."""
    scene, states = solution.system.scene, np.real(solution.q[steps, elastic_coordinates(solution, body)])
    found = np.zeros((len(states), 2))
    for first in range(0, len(states), _AT_ONCE):
        some = slice(first, first + _AT_ONCE)
        stress = point_stress(np.real(stress_components(scene, body, states[some])))
        found[some] = np.column_stack([stress.min(axis=1, initial=0), stress.max(axis=1, initial=0)])
    found[np.abs(found).max(axis=1, initial=0) <= round_off(scene, body)] = 0
    return found


def largest_stress(solution: Solution) -> np.ndarray:
    """Largest magnitude of the stress of any flexible body at every time, (n_t,)."""
    flexible = [name for name, body in solution.system.scene.bodies.items() if isinstance(body, ModelBody)]
    every = [np.zeros(len(solution.times)), *(np.abs(stress_range(solution, body)).max(axis=1) for body in flexible)]
    return np.asarray(np.max(every, axis=0))


def round_off(scene: ResolvedScene, body: str) -> float:
    """Stress below which it counts as zero: of a strain that is round-off in the stiffest material that the model names."""
    nominal = scene.model(flexible_body(scene, body).model).nominal
    return STRAIN * max((float(value) for name, value in nominal.items() if "youngs_modulus" in name), default=0.0)


def told(stress: np.ndarray, limit: float) -> float:
    """Largest finite magnitude of stresses, zero if that is not above a limit."""
    largest = float(np.abs(stress[np.isfinite(stress)]).max(initial=0.0))
    return largest if largest > limit else 0.0


FORMATS = ("png", "svg", "pdf")


@dataclass(frozen=True)
class View:
    """Choices of pictures that a user can make.

    Attributes
    ----------
    perspective
        Whether what is nearer is larger; else the projection is parallel and has a scale.
    triads
        Whether the axes of the bodies' frames are drawn.
    format
        Of the files: of planar scenes also svg or pdf, which stay sharp at every size.
    """

    perspective: bool = False
    triads: bool = False
    format: str = "png"

    def check(self, scene: Scene) -> None:
        """Refuse choices that pictures of a scene do not have.

        Raises
        ------
        InputError
            There is no such format, pictures of space are to be vectors, or a planar scene is to be seen as space is.
        """
        if self.format not in FORMATS:
            raise InputError(f"there are no pictures of format {self.format!r}. Take one of {', '.join(FORMATS)}.")
        if not scene.space.camera and (self.perspective or self.triads):
            raise InputError("perspective and triads belong to pictures of space, and this scene is planar: leave them out.")
        if scene.space.camera and self.format != "png":
            raise InputError(f"pictures of space consist of pixels and cannot be written as {self.format}: leave the format out.")
