"""Doubts about bodies that tension stiffens across itself.

Forces of joints that hold a body at both ends: its deflection pulls at them long before it is stiffer by that.

A load across a body is held in proportion to the deflection w, the tension of the body grows with w^2: of a clamped bar that is bent by a
fifth of its thickness the joints hold three times as much along it as across it, while its deflection is 3 % off.

Derivatives of the forces of joints that hold a body at both ends: they feel before the forces what its deflection pulls with.

Beside a force V across, a pull N makes sqrt(V^2 + N^2) larger by N^2 / 2 V^2, and N grows with the square of the deflection. The same is
asked of the states that the derivatives lead to,

    d missing / dx  =  (missing(x + h) - missing(x - h)) / 2 h
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from toolkit.components.bodies.model_body import ModelBody
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.near_ties import first_largest
from toolkit.foundation.units import unit
from toolkit.foundation.verdict import STATES, Caution, check
from toolkit.responses.energy import largest_in
from toolkit.responses.joint_force import JointForce
from toolkit.responses.over_time import OverTime
from toolkit.responses.pencil import free_pencil, real_pencil
from toolkit.responses.response import Response
from toolkit.responses.vibration import any_pencil_of
from toolkit.scene.changed_numbers import with_numbers
from toolkit.scene.scene import Scene
from toolkit.solvers.free_motions import undamped_rates
from toolkit.system.renewal import renewed
from toolkit.system.solution import Solution, elastic_coordinates
from toolkit.validity.bodies.deformation import LIMIT, divided, instants_of
from toolkit.validity.bodies.led_points import asked_vibrations
from toolkit.validity.bodies.pulled_body import PulledBody
from toolkit.validity.bodies.stiffened_bodies import (
    StiffenedState,
    TooLarge,
    most_pulled,
    pulled_bodies,
    stiffened_state,
    stiffened_states,
    too_large,
)

UNIMPORTANT_TENSION, GRADIENT_TENSION = 1e-5, 1e-6
"""Part of the critical force of a body below which its tension is no twentieth of what joints hold across it, and changes no gradient of
that by as much."""
EXAMINED_SHARE = 5e-3
"""Part of a joint's force that a deflection pulls with from which its gradients are looked at: this part grows with the square of the
deflection or more, by a thickness with ten times its relative change."""
UNCOUNTED_FORCE_FACTOR = 100.0
"""Factor by which a force is off above which a message gives no factor."""
SMALL_FORCE_PART = 0.1
"""Part of the largest force in any joint below which a force does not count."""
MOST_NAMED = 3
"""Largest number of responses, derivatives or vibrations that are named."""
EXAMINED_INSTANTS = 24
"""Number of instants among which the largest force of a joint is sought."""


class Lacking(NamedTuple):
    """Part of a joint's force that the equations lack."""

    missing: float
    size: float  # the largest that it is in the motion
    counts: float  # the same, but at least a part of the largest force in any joint


@check("tension")
def pulled_joints(solution: Solution) -> Iterator[Caution]:
    """Doubts about responses that are joint forces, at the end or over time, and lack the pull of a deflection."""
    low = {name: each for name, each in lacking_joints(solution).items() if abs(each.missing) > LIMIT * each.counts > 0}
    if low:
        body, scene = most_pulled(solution), solution.system.scene
        asked = joint_forces(scene)
        told = [
            f"{name} by {abs(each.missing):.3g} {unit(scene.units, asked[name][0].unit_quantity)}, where it is {each.size:.3g} at the most"
            for name, each in list(low.items())[:MOST_NAMED]
        ]
        much = max(abs(each.missing) / each.size if each.size > 0 else UNCOUNTED_FORCE_FACTOR for each in low.values())
        yield pulled_joints.caution(
            f"the deflection of {body} pulls at what holds its ends, which these equations do not know: forces of joints are off, "
            f"{', '.join(told)}. Linear FFRF knows this between frames, and not inside of one. Fix: "
            f"{divided(scene, body, min(much, UNCOUNTED_FORCE_FACTOR) / LIMIT)}.",
        )


def lacking_joints(solution: Solution) -> dict[str, Lacking]:
    """Responses that are joint forces, with the pull of deflections that each lacks; empty where nothing grows."""
    if Lacking not in solution.known:
        solution.known[Lacking] = _lacking(solution)
    found: dict[str, Lacking] = solution.known[Lacking]
    return found


def _lacking(solution: Solution) -> dict[str, Lacking]:
    asked = joint_forces(solution.system.scene)
    known = pulled_bodies(solution) if asked and not solution.spins else {}
    grown = _most_grown(solution, known)
    found: dict[str, Lacking] = {}
    for n in set() if grown is None else {grown, len(solution.times) - 1}:
        mine = {name: each for name, (each, at_end) in asked.items() if n == (len(solution.times) - 1 if at_end else grown)}
        found |= _low(solution, known, n, mine)
    return found


def joint_forces(scene: Scene) -> dict[str, tuple[JointForce, bool]]:
    """Responses that are joint forces, or made of them, by name; and whether they are those at the end."""
    found = {name: (getattr(each, "of", each), not isinstance(each, OverTime)) for name, each in scene.responses.items()}
    return {name: (each, at_end) for name, (each, at_end) in found.items() if isinstance(each, JointForce)}


def _most_grown(solution: Solution, known: Mapping[str, PulledBody]) -> int | None:
    """Number of the state where deflections make lines grow most; None where no joint would feel it."""
    parts: list[tuple[float, int]] = []
    for body, law in known.items():
        elastic = np.real(solution.q[:, elastic_coordinates(solution, body)])
        instants = instants_of(solution, body)
        grown = law.measures(elastic[instants])[1]
        worst = first_largest(grown)
        parts.append((float(grown[worst]), int(instants[worst])))
    part, n = max(parts, default=(0.0, 0))
    return n if part > (GRADIENT_TENSION if solution.dq.shape[2] else UNIMPORTANT_TENSION) else None


def _low(solution: Solution, known: Mapping[str, PulledBody], n: int, asked: Mapping[str, JointForce]) -> dict[str, Lacking]:
    """Joint forces that responses lack at one state, by name."""
    state = stiffened_state(solution, known, n) if asked else None
    if state is None or not np.any(state.growing):
        return {}
    more = np.array(solution.multipliers)
    more[n] = more[n] + state.yields.multipliers(state.growing)
    pulled, found = replace(solution, multipliers=more), dict[str, Lacking]()
    steps = np.unique(np.linspace(0, len(solution.times) - 1, EXAMINED_INSTANTS).astype(int))
    held = SMALL_FORCE_PART * float(np.abs(np.real(solution.multipliers[n])).max(initial=0.0))
    for name, response in asked.items():
        here, there = (float(np.real(response.at(each, n).value)) for each in (solution, pulled))
        size = max([abs(here), *(abs(float(np.real(response.at(solution, int(k)).value))) for k in steps)])
        found[name] = Lacking(there - here, size, max(size, held))
    return found


STEP = 1e-3
"""Part of a variable by which it is moved."""
MISSING_DERIVATIVE = 0.1
"""Part of a derivative that may be missing without a word, as of other errors of gradients."""
UNIMPORTANT_EFFECT = 0.02
"""A derivative that changes the force by less than this part, where its variable changes by all of itself, is compared with that."""


@check("tension")
def steep_joints(solution: Solution) -> Iterator[Caution]:
    """Derivatives of forces of joints that lack more of themselves than `MISSING_DERIVATIVE`, where the solution holds derivatives."""
    low = {name: each for name, each in lacking_joints(solution).items() if abs(each.missing) > EXAMINED_SHARE * each.counts > 0}
    off: dict[tuple[str, str], tuple[float, float]] = {}
    for x, variable in enumerate(solution.system.design if low else ()):
        step = STEP * (abs(variable.value) or 1.0)
        try:
            more, less = (lacking_joints(_moved(solution, x, each)) for each in (step, -step))
        except ToolkitError:
            continue
        for name, each in low.items():
            if name in more and name in less:
                missing = (more[name].missing - less[name].missing) / (2 * step)
                slope = _slope(solution, name, each, x)
                if abs(missing) > MISSING_DERIVATIVE * max(slope, UNIMPORTANT_EFFECT * each.counts * STEP / step):
                    off[name, variable.name] = missing, abs(missing) / slope if slope else np.inf
    if off:
        worst = sorted(off, key=lambda pair: -off[pair][1])[:MOST_NAMED]
        told = ", ".join(f"{f} by {x} by {off[f, x][0]:.3g}{_part(off[f, x][1])}" for f, x in worst)
        yield steep_joints.caution(
            f"the deflection of {most_pulled(solution)} pulls at what holds its ends, which these equations do not know: derivatives of "
            f"the forces there lack what that adds, {told}. Linear FFRF knows this between frames, and not inside of one. Fix: a "
            "model with all nodal coordinates (without [basis]), and frames = 2 or more.",
        )


def _moved(solution: Solution, x: int, step: float) -> Solution:
    """The states that the derivatives lead to, of the scene at the other number."""
    system = solution.system
    variable = tuple(system.design)[x]
    scene, paths = with_numbers(_by_tangents(system.scene), {variable.name: variable.value + step})
    names = ("q", "v", "a", "multipliers")
    states = {name: getattr(solution, name) + step * getattr(solution, f"d{name}")[..., x] for name in names}
    return replace(solution, system=renewed(system, scene, paths), **states)


def _by_tangents(scene: Scene) -> Scene:
    """The scene whose reduced bodies follow the tangent at their own design, where they are known at that alone."""
    bodies = {
        name: body.model_copy(update={"extrapolation": "first-order"}) if isinstance(body, ModelBody) else body
        for name, body in scene.bodies.items()
    }
    return scene.model_copy(update={"bodies": bodies})


def _slope(solution: Solution, name: str, lacking: Lacking, x: int) -> float:
    """The largest derivative in the motion."""
    response = solution.system.scene.responses[name]
    assert isinstance(response, Response)
    return float(largest_in(response, solution, lacking.size).slopes[x])


def _part(part: float) -> str:
    return f" ({part:.0%} of the largest)" if part < 1 else ""


FREE_MOTION_PART = 1e-9
"""Part of the largest squared frequency below which a frequency is round-off: a motion that nothing holds."""


def raised_by_tension(solution: Solution) -> np.ndarray:
    """Ratio of true frequencies to those of the equations, for all vibrations around the last state; empty without tension.

    They are in order from the slowest on.
    """
    state = _last(solution)
    if state is None:
        return np.zeros(0)
    weights = solution.system.weights[: solution.system.n_q]
    pencil = real_pencil(any_pencil_of(solution))
    motions, reduced = free_pencil(weights, pencil)
    more = motions.T @ np.array([state.adds(each) for each in motions.T]).T
    one, other = (undamped_rates(each, reduced.mass) for each in (reduced.stiffness, reduced.stiffness + more))
    fast = one**2 > FREE_MOTION_PART * np.max(one, initial=0.0) ** 2
    found: np.ndarray = np.divide(other, one, out=np.ones(len(one)), where=fast)
    return found


def _last(solution: Solution) -> StiffenedState | None:
    """Last state of a solution, if tension counts in it."""
    last = len(solution.times) - 1
    states = stiffened_states(solution)
    found = next((each for each in states if each.instant == last), None)
    return stiffened_state(solution, pulled_bodies(solution), last) if states and found is None else found


UNCOUNTED_FACTOR = 20.0
"""Factor by which a number is too large above which a message gives no factor."""
DERIVATIVE_ERROR_LIMIT = 0.1
"""Relative error of a derivative of a motion above which there is a doubt, as of other errors of gradients."""
DERIVATIVE_ERROR_RATIO = 3.0
"""Ratio of the error of a deflection's derivative by the load to its own: w (1 + c w^2) = f gives c w^2 and 3 c w^2."""


@check("tension", STATES)
def tension(solution: Solution, lateral: bool = False) -> Iterator[Caution]:
    """Tension stiffens a body across itself, which linear deformations in its own frame do not know.

    Limit: 5 % of a deflection, of a derivative in statics, or of a frequency; a remark where a run with more frames, made for
    gradients, changes no answer by half of that.
    Fix: more floating frames (`frames`).

    Parameters
    ----------
    lateral
        Whether derivatives are asked for that the solution does not hold.
    """
    found = too_large(solution)
    if found is not None and found.part > LIMIT:
        part = found.part / (1 - found.part) if found.part < 1 else np.inf
        yield tension.caution(_too_large(solution, found), body=found.body, part=part)
    elif not solution.steps:
        yield from _of_derivatives(solution, lateral)
    elif found is not None and solution.dq.shape[2] and DERIVATIVE_ERROR_RATIO * found.part > DERIVATIVE_ERROR_LIMIT:
        yield tension.caution(_steeper(solution, found), body=found.body, part=DERIVATIVE_ERROR_RATIO * found.part)
    if found is None or found.part <= LIMIT:
        yield from pulled_joints(solution)
    yield from tension_of_vibrations(solution, asked_vibrations(solution))


def _steeper(solution: Solution, found: TooLarge) -> str:
    return (
        f"tension stiffens {found.body} across itself, which these equations do not know: its displacements are {found.part:.1%} too "
        "large, and as tension grows with their square derivatives by what bends it are off by about "
        f"{DERIVATIVE_ERROR_RATIO * found.part:.0%}. {_remedy(solution, found.body, DERIVATIVE_ERROR_RATIO * found.part)}"
    )


def tension_of_vibrations(solution: Solution, asked: Mapping[str, int]) -> Iterator[Caution]:
    """A doubt about vibrations that tension makes faster, from their names and numbers from the slowest on."""
    times = raised_by_tension(solution) if asked and stiffened_states(solution) else np.zeros(0)
    high = {name: float(times[k - 1]) for name, k in asked.items() if k <= len(times) and times[k - 1] > 1 + LIMIT}
    if not high:
        return
    body, highest = most_pulled(solution), max(high.values())
    told = [f"{name} by {1 - 1 / factor:.1%}" for name, factor in list(high.items())[:MOST_NAMED]]
    more = f" and {len(high) - MOST_NAMED} more" if len(high) > MOST_NAMED else ""
    yield tension.caution(
        f"tension stiffens {body} across itself, which makes vibrations faster than these equations say: {', '.join(told)}{more} too slow. "
        f"Their derivatives by what pulls at it are missing, too. {_remedy(solution, body, highest**2 - 1)}",
    )


def _of_derivatives(solution: Solution, lateral: bool) -> Iterator[Caution]:
    """Doubts about derivatives of an equilibrium that nothing bends, by what would bend it."""
    for state in stiffened_states(solution):
        times = _times_of_derivatives(solution, state) if solution.dq.shape[2] else 1 + state.largest() if lateral else 1.0
        if times > 1 + LIMIT:
            body = most_pulled(solution)
            yield tension.caution(
                f"tension stiffens {body} across itself, and these equations do not know it: derivatives by what bends it are up to "
                f"{_times(times)} as large as they should be. {_remedy(solution, body, times - 1)}",
            )


def _times_of_derivatives(solution: Solution, state: StiffenedState) -> float:
    """Largest factor by which the derivatives of coordinates that a solution holds are too large."""
    weights, worst = solution.system.weights[: solution.system.n_q], 1.0
    for moved in np.real(solution.dq[0]).T:
        force = state.adds(np.where(state.elastic, moved, 0.0))
        less, work = state.yields(force), float(force @ moved)
        if not work > 0:
            continue
        size = float(np.abs(weights * less).max() / np.abs(weights * moved).max())
        part = min(size / (1 + float(force @ less) / work), 1.0)
        worst = max(worst, 1 / (1 - part) if part < 1 else np.inf)
    return worst


def _too_large(solution: Solution, found: TooLarge) -> str:
    when = f" at t = {solution.times[found.state.instant]:.4g}" if solution.steps else ""
    why = "its own deflection, between what holds it, pulls at" if found.by_itself else "tension pulls at"
    times = 1 / (1 - found.part) if found.part < 1 else np.inf
    stiffer = float(np.fmax(1 + found.state.largest(), times))  # a state that loses its stability elsewhere tells no largest one
    return (
        f"{why} {found.body}{when} and stiffens it across itself, which these equations do not know: its largest displacement is "
        f"{_times(times)} as large as it should be, stresses and whatever depends on it are "
        f"off as much, derivatives by what bends it are up to {_times(stiffer)} as large, and frequencies across it up to "
        f"{1 - 1 / np.sqrt(stiffer):.0%} too low. {_remedy(solution, found.body, stiffer - 1)}"
    )


def _times(factor: float) -> str:
    return f"{factor:.3g} times" if factor < UNCOUNTED_FACTOR else "many times"


def _remedy(solution: Solution, body: str, part: float) -> str:
    helps = divided(solution.system.scene, body, part / LIMIT)
    return f"Linear FFRF knows this between frames, and not inside of one. Fix: {helps}."
