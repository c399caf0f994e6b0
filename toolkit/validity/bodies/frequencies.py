"""Frequencies that the models of bodies make too high, by elements that are too long or shapes that are left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from toolkit.foundation.units import unit
from toolkit.foundation.verdict import Caution, check
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.solution import Solution, elements_of, flexible_body, is_in_pieces
from toolkit.validity.bodies.beam_assumptions import beams_of, times_as_many
from toolkit.validity.bodies.deformation import LIMIT, whole_bodies
from toolkit.validity.bodies.few_shapes import cautions_of_few_shapes
from toolkit.validity.bodies.full_scene import cautions_of_raised, listed_parts
from toolkit.validity.bodies.known_chain import chain
from toolkit.validity.bodies.led_points import lines_on_bodies
from toolkit.validity.bodies.merging_vibrations import merging_of
from toolkit.validity.bodies.physics import critical_loads
from toolkit.validity.bodies.pulled_joints import tension_of_vibrations
from toolkit.validity.bodies.sheared_beams import sheared_vibrations

FACTOR = 1440.0
ITERATIONS = 40
"""Iterations of Newton's method, which gains a factor of 1.5 far from the root of a cubic, and doubles the digits near it."""


def resolved_frequency(scene: ResolvedScene, body: str) -> float:
    """Frequency that the elements of a body make too large by `LIMIT`, in 1/time; inf where they are not known."""
    behind = chain(scene, body)
    if behind is None:
        return float(np.inf)
    found = beams_of(behind)
    (mass,) = flexible_body(scene, body).some_invariants(scene, "mass")
    per_stretch = float(np.real(mass)) / float(found.axial @ found.lengths)  # of E A, which the mass goes with
    slowest = float(np.max(per_stretch * found.lengths**4 / found.gyration))  # m l^4 / E I
    return float(np.sqrt(FACTOR * LIMIT / slowest) / (2 * np.pi))


def raised_by_elements(frequency: float, limit: float) -> float:
    """Relative error e by which a frequency is too high where `limit` is `resolved_frequency`.

    The error is that of the true frequency, which is 1 + e times less.

        e (1 + e)^2 = LIMIT (frequency / limit)^2
    """
    error = wanted = LIMIT * (frequency / limit) ** 2
    for _ in range(ITERATIONS):  # Newton's, from above
        error -= (error * (1 + error) ** 2 - wanted) / ((1 + error) * (1 + 3 * error))
    return error


@check("coarse-vibrations")
def too_fast_for_elements(scene: ResolvedScene, frequencies: Mapping[str, float], doubt: bool) -> Iterator[Caution]:
    """The elements of a body are too long for vibrations as fast as those that are asked for.

    Limit: 5 % of a frequency.
    Fix: more elements.
    """
    label = unit(scene.units, "rate")
    for body in whole_bodies(scene):
        if is_in_pieces(scene, body):
            continue  # told by the slowest vibration that they leave out, which may be torsion
        limit = resolved_frequency(scene, body)
        beyond = {name: value for name, value in frequencies.items() if value > limit}
        if beyond:
            parts = {name: raised_by_elements(value, limit) for name, value in beyond.items()}
            most = max(beyond.values())
            yield too_fast_for_elements.caution(
                f"frequencies are too high where {body} vibrates, {listed_parts(parts, 'about')}: from {limit:.4g} {label} on, where "
                f"it is {LIMIT:.0%}, its {elements_of(scene, body)} are too long. Fix: build the model with "
                f"{times_as_many(np.sqrt(most / limit))} as many.",
                doubt,
            )


def cautions_of_frequencies(
    solution: Solution, frequencies: Mapping[str, float], doubt: bool, differentiated: bool
) -> Iterator[Caution]:
    """Cautions about frequencies around the last state that the models of the bodies make too high.

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
    """Cautions about a list of the lowest modes around the last state, in cycles per time.

    Parts that keep few modes are compared with all of theirs. Frequencies that are asked for by their `count` are doubted as
    those of responses are. Of all that there are, where None is asked for, the fastest are those of the elements, and no doubt.
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


REMARKED_DAMPING, DOUBTED_DAMPING = 0.01, 0.3
"""Parts of the critical damping above which it is told, and of the lowest frequency above which it is a doubt: sqrt(1 - 0.3^2) is 5 %
below one."""


@check("damped")
def cautions_of_damping(damping: np.ndarray, mass: np.ndarray, squares: np.ndarray, shapes: np.ndarray) -> Iterator[Caution]:
    """Frequencies are undamped, and the scene has dampers.

    Limit: 1 % of the critical damping; a doubt from 30 % of the lowest frequency's on.
    Fix: the responses `damped-frequency` and `damping-ratio`.

        zeta_k = y_k^T C y_k / (2 omega_k y_k^T M y_k),    damped frequency omega_k sqrt(1 - zeta_k^2)

    Parameters
    ----------
    damping, mass : array (n_q, n_q)
        C and M.
    squares : array (n_modes,)
        omega^2.
    shapes : array (n_q, n_modes)
        y.
    """
    vibrating = squares > 0
    damped, inert = (np.einsum("im,ij,jm->m", shapes, each, shapes)[vibrating] for each in (damping, mass))
    ratios = damped / (2 * np.sqrt(squares[vibrating]) * inert)
    if not ratios.size or not ratios.max() > REMARKED_DAMPING:
        return
    most = int(np.argmax(ratios > DOUBTED_DAMPING if ratios.max() > DOUBTED_DAMPING else ratios > REMARKED_DAMPING))
    yield cautions_of_damping.caution(
        f"these frequencies are undamped. Damping is up to {ratios.max():.2g} of the critical one; that at "
        f"{np.sqrt(squares[vibrating][most]) / (2 * np.pi):.4g} Hz, {ratios[most]:.2g} of it, "
        + ("lowers it by " + f"{1 - np.sqrt(1 - ratios[most] ** 2):.1%}." if ratios[most] < 1 else "does not vibrate at all."),
        doubt=bool(ratios[0] > DOUBTED_DAMPING),
    )
