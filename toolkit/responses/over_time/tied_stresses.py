"""Largest stresses that occur at several places with other derivatives: there the derivative jumps.

A beam held alike at both ends is stressed alike there. The thickness of one half then moves the stress of its own end and not that of the
other, and the largest of both follows whichever grows.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Caution
from toolkit.responses.instant import slope_at
from toolkit.responses.over_time.tied_extremes import JUMP, TIED
from toolkit.responses.stress.stress import MaxStress
from toolkit.responses.stress.stress_places import stress_places
from toolkit.system.solution import Solution

LOOKED_AT = 8
"""Largest number of places of one stress that are looked at, as each asks for a derivative of its own."""
NEAR, APART = 0.01, 0.1
"""Part of the stress by which a place, so far away in parts of the body's extent, may be stressed less without a remark: what a mesh or a
basis leaves open of it, so that the largest may be there."""
UNFELT = 1e-3
"""Part of the stress by which a variable has to change it, if it changes by all of itself, for a jump to be worth a word."""


def tied_stresses(solution: Solution) -> Iterator[Caution]:
    """Caution for every derivative of a largest stress that jumps (doubt) or nearly does (remark), where derivatives are held."""
    if solution.run_times is not None or not solution.dq.shape[2]:
        return
    for name, response in solution.system.scene.responses.items():
        if isinstance(response, MaxStress) and (solution.steps or not response.needs_motion):
            yield from _of(name, response, solution)


def _of(name: str, response: MaxStress, solution: Solution) -> Iterator[Caution]:
    components = response.components(solution)
    stress = np.real(response.signed(components))
    places = [*_tied(stress), *_nearly_tied(response, solution, stress)]
    if len(places) < 2:
        return
    slopes = np.array([_slope(response, solution, components, place) for place in places])
    words = [_where(response, solution, instant, column % components.shape[1]) for instant, column in places]
    for x, variable in enumerate(solution.system.design):
        size = abs(variable.value) or (solution.system.scene.size if variable.path.startswith("points.") else 1.0)
        if np.ptp(slopes[:, x]) > max(JUMP * np.abs(slopes[:, x]).max(), UNFELT * stress.max() / size):
            k = int(np.argmax(np.abs(slopes[:, x] - slopes[0, x])))
            below = 1 - stress[places[k]] / stress.max()
            yield Caution(
                "tied-extreme",
                f"the derivative of {name} by {variable.name} jumps {'here' if below <= TIED else 'near here'}, as the stress of "
                f"{response.body} is {'the same' if below <= TIED else f'but {below:.1g} of itself larger'} {words[0]} "
                f"{'as' if below <= TIED else 'than'} {words[k]}: {slopes[0, x]:.4g} by the first, {slopes[k, x]:.4g} by the other one. "
                "Ask for the stress at one of these places (stress-at-point), or for a smooth maximum (ks-stress).",
                doubt=bool(below <= TIED),
            )


def _tied(stress: np.ndarray) -> list[tuple[int, int]]:
    """Instants and columns of the largest stress (n_t, n), each column once, in their order."""
    largest = stress.max()
    if not largest > 0:
        return []
    columns = np.flatnonzero(stress.max(axis=0) >= (1 - TIED) * largest)[:LOOKED_AT]
    return [(int(np.argmax(stress[:, column])), int(column)) for column in columns]


def _nearly_tied(response: MaxStress, solution: Solution, stress: np.ndarray) -> list[tuple[int, int]]:
    """Instant and column of the largest stress far from where it is largest, if it is nearly the same; of known places alone."""
    highest = stress.max(axis=0)
    try:
        place = stress_places(solution.system.scene, response.body).place
    except InputError:
        return []
    first = int(np.argmax(highest))
    places = np.resize(place, (len(highest), place.shape[1]))  # again, where the opposite sign counts too
    far = np.linalg.norm(places - places[first], axis=1) > APART * np.ptp(place, axis=0).max()
    if not far.any():
        return []
    column = int(np.argmax(np.where(far, highest, -np.inf)))
    near = (1 - NEAR) * highest[first] <= highest[column] < (1 - TIED) * highest[first]
    return [(int(np.argmax(stress[:, column])), column)] if near else []


def _slope(response: MaxStress, solution: Solution, components: np.ndarray, place: tuple[int, int]) -> np.ndarray:
    """Total derivative (n_x,) of the stress at one place."""
    weights = np.zeros(response.signed(components).shape)
    weights[place] = 1
    found, step = response.chain(solution, components, 0.0, weights), place[0] if response.when == "all" else -1
    return slope_at(found._replace(q=None if found.q is None else found.q[step]), solution, step)


def _where(response: MaxStress, solution: Solution, instant: int, point: int) -> str:
    """Place, and time of a motion, of a stress point, in words for a message."""
    try:
        place = ", ".join(f"{x:.4g}" for x in stress_places(solution.system.scene, response.body).place[point])
        where = f"at ({place})"
    except InputError:  # of a model that does not say where its points are
        where = f"at its stress point {point}"
    return where + (f" and t = {solution.times[instant]:.4g}" if solution.steps else "")
