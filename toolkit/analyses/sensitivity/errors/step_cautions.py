"""What to say about errors by the length of the steps.

Doubts weighed by what was asked for: energy that steps took or created, and deflections that a model has wrong.

A comparison of values with those of shorter steps tells how wrong they are, unless both runs lack the same: a vibration that steps damp
away takes its energy with it in both. Then the defect of the energy stays what it is; where the scheme merely errs, it falls with the order
p of the scheme,

    E(h / 2) = E(h) / 2^p

A body whose deflections are off by a part e under the same forces is as one with 1 / (1 + e) times its stiffness: a run with that tells
what the answers feel of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from toolkit.analyses.run_start import known_start
from toolkit.analyses.sensitivity.errors.step_error import (
    DERIVATIVE_FACTOR,
    Gradients,
    StepError,
    Values,
    first_order,
    shorter_steps,
)
from toolkit.analyses.sensitivity.preparation import evaluate_with_gradients
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.value_types import Scalar
from toolkit.foundation.verdict import Caution
from toolkit.responses.motion import Displacement
from toolkit.scene.resolution import ResolvedScene
from toolkit.system.renewal import softened
from toolkit.system.solution import Solution, deforming, elastic_coordinates
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.bodies.known_chain import chain
from toolkit.validity.energy_balance import energy_defects
from toolkit.validity.motion import ENERGY_DEFECT_LIMIT, Measures
from toolkit.validity.scene_cautions import bodies_of_stress

K = TypeVar("K")

VALUE_LIMIT, GRADIENT_LIMIT = 0.042, 0.1
"""Estimated errors above which values and gradients are not trusted: estimates are right to a factor of about two."""
ROUGH_GRADIENT = 0.05
"""Estimated error above which gradients that are trusted have a remark."""
WANTED_ERROR = 0.01
"""Error for which a shorter step is proposed."""
MOST_NAMED_NUMBERS = 3
"""So many numbers are named at the most."""


def step_cautions(found: StepError | None, values: Values, gradients: Gradients, options: RunOptions) -> Iterator[Caution]:
    """Doubts about values and gradients that other steps change too much.

    Parameters
    ----------
    found : StepError
        None if no other steps worked.
    values, gradients : dict
        Of the run itself.
    """
    if found is None:
        yield Caution(
            "steps-not-checked",
            "nothing is known about errors by the length of the steps: neither longer nor shorter ones gave a result. Try a smaller "
            "solver.step.",
        )
        return
    wrong = {f: error for f, error in found.values.items() if not error <= VALUE_LIMIT}
    of_values = (
        f"{'; '.join(_told(f, error, values[f], found.other_values[f], found.how) for f, error in _worst(wrong))}{_more(wrong)}."
    )
    if wrong and not found.vibrations:
        yield Caution("steps", f"{of_values} {_remedy(wrong, found, options)}")
    slopes = {(f, x): error for f, each in found.gradients.items() for x, error in each.items() if not error <= GRADIENT_LIMIT}
    told = [
        _told(f"the derivative of {f} by {x}", error, gradients[f][x], found.other_gradients[f][x], _how(found, f, x))
        for (f, x), error in _worst(slopes)
    ]
    of_slopes = f"{'; '.join(told)}{_more(slopes)}."
    if slopes and not found.vibrations:
        yield Caution("gradient-steps", f"{of_slopes} {_remedy(slopes, found, options)}")
    if (wrong or slopes) and found.vibrations:
        both = " ".join([*([of_values] if wrong else []), *([of_slopes[0].upper() + of_slopes[1:]] if slopes else [])])
        yield Caution("lost-vibrations" if wrong else "gradient-steps", f"{both} {_against_vibrations(found)}")
    if not slopes:
        yield from _rough_gradients(found.gradients)
    small = {f: error for f, error in found.own_values.items() if f not in wrong and error > VALUE_LIMIT}
    small |= {
        f"the derivative of {f} by {x}": error
        for f, errors in found.own_gradients.items()
        for x, error in errors.items()
        if (f, x) not in slopes and error > GRADIENT_LIMIT
    }
    if small:
        told = [f"{what} by about {error:.0%}" for what, error in _worst(small)]
        yield Caution(
            "small-numbers",
            f"errors are small against the largest numbers in the motion, but here some are small themselves, and off by more of what they "
            f"are: {'; '.join(told)}{_more(small)}.",
            doubt=False,
        )


def _rough_gradients(errors: Gradients) -> Iterator[Caution]:
    """A remark on derivatives that are trusted, and whose estimated error is no small one."""
    rough = {
        f"{f} by {x}": error
        for f, each in errors.items()
        for x, error in each.items()
        if ROUGH_GRADIENT < error <= GRADIENT_LIMIT
    }
    if rough:
        told = [f"{name} by about {error:.1%}" for name, error in _worst(rough)]
        yield Caution(
            "rough-gradients",
            f"derivatives are off by the length of the steps: {'; '.join(told)}{_more(rough)} (they are doubted above "
            f"{GRADIENT_LIMIT:.0%}). Fix: a shorter solver.step.",
            doubt=False,
        )


def _worst(errors: Mapping[K, float]) -> list[tuple[K, float]]:
    """The largest ones, undefined ones first."""
    return sorted(errors.items(), key=lambda item: -np.nan_to_num(item[1], nan=np.inf))[:MOST_NAMED_NUMBERS]


def _told(what: str, error: float, ours: Scalar, other: Scalar, how: str) -> str:
    size = f"about {error:.1%}" if error < 1 else "as much as it is large, or more,"
    there = f"{np.real(other):.5g}" if np.isfinite(other) else "unknown"
    return f"{what} is off by {size} because of the length of the steps: {np.real(ours):.5g} as it is, {there} {how}"


def _how(found: StepError, response: str, variable: str) -> str:
    """How the other derivative was found."""
    return f"at the peak between the steps, {found.how}" if (response, variable) in found.at_peaks else found.how


def _more(errors: Sized) -> str:
    return f" (and {len(errors) - MOST_NAMED_NUMBERS} more)" if len(errors) > MOST_NAMED_NUMBERS else ""


def _remedy(errors: Mapping[str, float] | Mapping[tuple[str, str], float], found: StepError, options: RunOptions) -> str:
    """A step, or an error of a step, that is expected to be short enough."""
    worst = min(1.0, max(np.nan_to_num(error, nan=1.0) for error in errors.values()))
    order = 1 if found.at_peaks & set(errors) else found.order  # a peak lies within a step, however exact this is
    part = (WANTED_ERROR / worst) ** (1 / order)
    if options.local_error is not None:
        return f"Try solver.local_error = {options.local_error * part**3:.1g} and solver.step = {options.step * part:.1g}, the longest one."
    if options.times is not None:
        return f"Try times whose steps are {1 / part:.2g} times shorter."
    first = ' solver.scheme = "arnold-bruels" is of second order and needs fewer steps.' if found.order == 1 else ""
    return f"Try solver.step = {options.step * part:.1g} or less.{first}"


def _against_vibrations(found: StepError) -> str:
    """What excites them, and what helps."""
    return (
        f"A load that sets in within few periods, or a start out of balance, excites {found.vibrations}, which the scheme takes out where "
        f"steps are longer than about a tenth of the period. Try solver.step = {found.step:.1g}; or, if nothing is to vibrate, let the "
        'load grow slowly, or begin with solver.start = "equilibrium".'
    )


ENERGY_ORDER_SLACK = 1.5
"""Factor by which the energy defect may fall less than by the order: it is a maximum over time, and steps are not yet short."""

LARGEST_DEFLECTION_ERROR = 0.5
"""Relative error of deflections above which their effect on the answers is not estimated."""
ESTIMATE_FACTOR = 2.0
"""The estimated errors of deflections may be too small by this factor."""

UNMOVED_DISPLACEMENT = 1e-5
"""Displacement, relative to the model size, below which there is no caution."""


class Answers(NamedTuple):
    """Values and gradients of a run, and the scales of their errors."""

    values: Values
    gradients: Gradients
    scales: Mapping[str, float]
    slope_scales: Gradients


def unless_it_converges(
    cautions: Iterable[Caution], solution: Solution, error: StepError | None, measures: Measures
) -> Iterator[Caution]:
    """The cautions, with those about energy as remarks where shorter steps tell that values are right and the defect goes away.

    The price is a run with steps half as long, where there is such a doubt.
    """
    told = list(cautions)
    doubted, balance = any(each.code == "energy" for each in told), measures["energy_balance"]
    if not doubted or error is None or not _converges(solution, error, balance):
        yield from told
        return
    yield from (each for each in told if each.code != "energy")
    yield Caution(
        "energy",
        f"energy balance: {max(balance.values()):.1%} of the largest energy or work is gained or lost (limit "
        f"{ENERGY_DEFECT_LIMIT:.0%}). The responses are not affected: with steps half as long this falls with the order of the "
        "scheme, and their estimated time-step error is "
        f"{max(error.values.values()):.1e} of their peaks.",
        doubt=False,
    )


def _converges(solution: Solution, error: StepError, balance: Mapping[str, float]) -> bool:
    """Whether values are known to be right, and no defect stays."""
    if not error.by_shorter_steps or not max(error.values.values(), default=0.0) <= VALUE_LIMIT:
        return False
    options = solution.options or solution.system.scene.solver
    try:
        halved = energy_defects(
            simulate(solution.system, shorter_steps(options, solution.whole_run, 2), known=known_start(solution))
        )
    except ToolkitError:
        return False
    allowed = ENERGY_ORDER_SLACK / 2 ** (1 if first_order(options) else 2)
    before = (balance["created"], balance["lost"])
    return all(now <= max(allowed * then, allowed * ENERGY_DEFECT_LIMIT) for now, then in zip(halved, before, strict=True))


def unless_unfelt(cautions: Iterable[Caution], solution: Solution, answers: Answers) -> Iterator[Caution]:
    """The cautions, with those about deflections as remarks where no answer feels them.

    The price is a run, where there is such a doubt and no stress of the body is asked for, which is off by as much as its deflections.
    """
    told = list(cautions)
    parts: dict[str, float] = {}
    for each in told:
        if each.doubt and each.body:
            parts[each.body] = parts.get(each.body, 0.0) + each.part
    felt = _felt(solution, answers, parts) if parts else LIMIT
    for each in told:
        unfelt = felt < LIMIT and each.doubt and each.body
        said = f" The responses hardly feel it: they change by {felt:.1e} at most of the largest that they are, by this and as much again."
        yield replace(each, text=each.text + said, doubt=False) if unfelt else each


def _felt(solution: Solution, answers: Answers, parts: Mapping[str, float]) -> float:
    """Largest change of an answer where deflections are off by twice these parts; that of derivatives is divided by `DERIVATIVE_FACTOR`."""
    asked = bodies_of_stress(solution.system.scene)
    known = max(parts.values()) <= LARGEST_DEFLECTION_ERROR and not asked & set(parts) and solution.run_times is None
    if not known or (answers.gradients and not solution.system.n_x):
        return LIMIT
    other = softened(solution.system, {body: 1 / (1 + ESTIMATE_FACTOR * part) for body, part in parts.items()})
    try:
        values, gradients = evaluate_with_gradients(simulate(other, _same_steps(solution)))
    except ToolkitError:
        return LIMIT
    changes = [_part(float(np.real(values[f])) - value, answers.scales[f]) for f, value in answers.values.items()]
    slopes = [
        _part(gradients[f][x] - slope, max(abs(slope), answers.slope_scales[f][x])) / DERIVATIVE_FACTOR
        for f, each in answers.gradients.items()
        for x, slope in each.items()
    ]
    return float(np.nan_to_num(max([*changes, *slopes], default=0.0), nan=np.inf))


def _part(change: Scalar, scale: float) -> float:
    return abs(change) / scale if scale > 0 else 0.0 if change == 0 else np.inf


def _same_steps(solution: Solution) -> RunOptions:
    """Options of the run, with the steps that it has chosen."""
    options = solution.options or solution.system.scene.solver
    if options.local_error is None:
        return options
    return options.model_copy(update={"times": tuple(map(float, solution.whole_run)), "local_error": None})


def turned_displacements(solution: Solution, values: Mapping[str, float], scales: Mapping[str, float]) -> Iterator[Caution]:
    """Displacements of bodies that the ground alone holds, which elements that turn would change by more than `LIMIT` of their scale."""
    scene = solution.system.scene
    for name in values:
        response = scene.responses.get(name)
        if isinstance(response, Displacement) and _is_held_by_its_frame(scene, response.body):
            off = _missed(solution, response)
            if scales[name] > 0 and off > max(LIMIT * scales[name], UNMOVED_DISPLACEMENT * scene.size):
                yield Caution(
                    "large-deformation",
                    f"{name} is off by about {off / scales[name]:.1%} of the largest that it is: {response.body} bends aside by more, and "
                    "elements that turn come back along it, which linear bodies do not know. frames = 2 or more in its table make this "
                    "smaller.",
                )


def _is_held_by_its_frame(scene: ResolvedScene, body: str) -> bool:
    """Whether a body stands on the ground and joints tie it to nothing, which could hold it back."""
    found: Any = deforming(scene).get(body)
    return found is not None and found.frame == "grounded" and not any(body in each.bodies for each in scene.joints.values())


def _missed(solution: Solution, response: Displacement) -> float:
    """The change of the response by the displacement of second order of its body; zero where its elements are not known."""
    behind = chain(solution.system.scene, response.body)
    if behind is None or not behind.is_full:
        return 0.0
    step, where = response.step(solution), elastic_coordinates(solution, response.body)
    lacks = behind.second_order(behind.displacements(np.real(solution.q[step : step + 1, where])))
    by_q = response.at(solution, step).q
    change = np.linalg.lstsq(behind.shapes, lacks[0])[0]
    return 0.0 if by_q is None else float(abs(np.real(by_q[where]) @ change))


MOST_NAMED = 5
"""So many are named at the most."""
MISSING_STIFFNESS = ("tension", "critical-load")
"""Doubts which say that forces along a body should change what they do not change here: zeros may be wrong."""


def unfelt_variables(gradients: Mapping[str, Mapping[str, float]]) -> Iterator[Caution]:
    """The remark that all derivatives by some variables are exactly zero: rightly so, or because another number was meant.

    Parameters
    ----------
    gradients : dict
        Response -> variable -> derivative.
    """
    variables = next(iter(gradients.values()), {})
    unfelt = [x for x in variables if all(slopes[x] == 0 for slopes in gradients.values())]
    if unfelt:
        named = ", ".join(unfelt[:MOST_NAMED]) + (f" and {len(unfelt) - MOST_NAMED} more" if len(unfelt) > MOST_NAMED else "")
        yield Caution(
            "unfelt",
            f"no response changes with {named}: all derivatives by {'them' if len(unfelt) > 1 else 'it'} are zero. That is right where "
            "nothing asked for depends on such a number, as equilibria without weight do not on densities; otherwise name another one.",
            doubt=False,
        )


def without_false_zeros(cautions: Sequence[Caution]) -> list[Caution]:
    """The same without the remark that zeros may be right, where a doubt says that they are not."""
    missing = any(each.doubt and each.code in MISSING_STIFFNESS for each in cautions)
    return [each for each in cautions if not (missing and each.code == "unfelt")]
