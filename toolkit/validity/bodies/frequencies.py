"""Frequencies that what describes the bodies makes too high: elements that are too long, or shapes that are left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from toolkit.foundation.verdict import Caution
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.lines_on_bodies import lines_on_bodies
from toolkit.validity.bodies.coarse_vibrations import too_fast_for_elements
from toolkit.validity.bodies.compressed.merging_vibrations import merging_of
from toolkit.validity.bodies.physics import critical_loads
from toolkit.validity.bodies.reduced.few_shapes import cautions_of_few_shapes
from toolkit.validity.bodies.reduced.raised_frequencies import cautions_of_raised
from toolkit.validity.bodies.shear.sheared_vibrations import sheared_vibrations
from toolkit.validity.bodies.tension.tension_cautions import tension_of_vibrations


def cautions_of_frequencies(
    solution: Solution, frequencies: Mapping[str, float], doubt: bool, differentiated: bool
) -> Iterator[Caution]:
    """By the models of the bodies, about the last state.

    Parameters
    ----------
    frequencies
        By what they are called, in cycles per time.
    doubt
        Whether what is said can be a reason for a doubt.
    differentiated
        Whether their derivatives are asked for.
    """
    yield from too_fast_for_elements(solution.system.scene, frequencies, doubt)
    yield from cautions_of_few_shapes(solution, frequencies, doubt, differentiated)


def cautions_of_modes(solution: Solution, frequencies: np.ndarray, count: int | None) -> Iterator[Caution]:
    """Of a list of the lowest modes about the last state, in cycles per time; parts that keep few modes are compared with all of theirs.

    Frequencies that are asked for by their `count` are doubted as those of responses are. Of all that there are, where None is asked for,
    the fastest are those of the elements, and no doubt.
    """
    yield from cautions_of_raised(solution, frequencies)
    yield from critical_loads(solution, lateral=True)
    numbers = {f"mode {k + 1}": k + 1 for k in range(len(frequencies))}
    yield from tension_of_vibrations(solution, numbers)
    yield from merging_of(solution, numbers)
    yield from lines_on_bodies(solution, numbers, values=False)
    named = {f"mode {k + 1}": float(each) for k, each in enumerate(frequencies)}
    yield from cautions_of_frequencies(solution, named, doubt=count is not None, differentiated=False)
    yield from sheared_vibrations(solution, named, differentiated=False)
