"""Frequencies that beam elements are too long for.

With consistent masses an element of length l makes a vibration of the angular frequency omega too fast by about

    omega^2 m l^4 / (1440 E I),    m per length

(the relative error of omega^2 is (beta l)^4 / 720, beta^4 = omega^2 m / E I; Hughes, The Finite Element Method, 1987, has it of a beam).
The elements of a body may differ: those count that are longest for their stiffness. Where a basis of few shapes stands for them, its own
error is not in it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution
from toolkit.scene.scene import Scene
from toolkit.system.flexible_bodies import elements_of, flexible_body, is_in_pieces
from toolkit.validity.bodies.beam_assumptions import beams_of, times_as_many
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.deformation import LIMIT, whole_bodies
from toolkit.validity.bodies.reduced.raised_frequencies import listed_parts

FACTOR = 1440.0
ITERATIONS = 40
"""Of Newton's method, which gains a factor of 1.5 in a step far from the root of a cubic, and doubles the digits near it."""


def resolved_frequency(scene: Scene, body: str) -> float:
    """The frequency that the elements of a body make `LIMIT` too large, in 1/time; inf where they are not known."""
    behind = chain(scene, body)
    if behind is None:
        return float(np.inf)
    found = beams_of(behind)
    (mass,) = flexible_body(scene, body).some_invariants(scene, "mass")
    per_stretch = float(np.real(mass)) / float(found.axial @ found.lengths)  # of E A, which the mass goes with
    slowest = float(np.max(per_stretch * found.lengths**4 / found.gyration))  # m l^4 / E I
    return float(np.sqrt(FACTOR * LIMIT / slowest) / (2 * np.pi))


def raised_by_elements(frequency: float, limit: float) -> float:
    """Part e by which a frequency is too high where `limit` is `resolved_frequency`.

    The error is that of the true frequency, which is 1 + e times less.

        e (1 + e)^2 = LIMIT (frequency / limit)^2
    """
    error = wanted = LIMIT * (frequency / limit) ** 2
    for _ in range(ITERATIONS):  # Newton's, from above
        error -= (error * (1 + error) ** 2 - wanted) / ((1 + error) * (1 + 3 * error))
    return error


def too_fast_for_elements(scene: Scene, frequencies: Mapping[str, float], doubt: bool) -> Iterator[Caution]:
    """Frequencies, by what they are called, that the elements of a flexible body make too large."""
    label = unit(scene.units, "rate")
    for body in whole_bodies(scene):
        if is_in_pieces(scene, body):
            continue  # told by the slowest vibration that they leave out, which may be torsion
        limit = resolved_frequency(scene, body)
        beyond = {name: value for name, value in frequencies.items() if value > limit}
        if beyond:
            parts = {name: raised_by_elements(value, limit) for name, value in beyond.items()}
            most = max(beyond.values())
            yield Caution(
                "coarse-vibrations",
                f"frequencies are too high where {body} vibrates, {listed_parts(parts, 'about')}: from {limit:.4g} {label} on, where "
                f"it is {LIMIT:.0%}, its {elements_of(scene, body)} are too long. Build the model with "
                f"{times_as_many(np.sqrt(most / limit))} as many.",
                doubt,
            )
