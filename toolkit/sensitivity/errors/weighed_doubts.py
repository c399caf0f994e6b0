"""Doubts weighed by what was asked for: energy that steps took or created, and deflections that a model has wrong.

A comparison of values with those of shorter steps tells how wrong they are, unless both runs lack the same: a vibration that steps damp
away takes its energy with it in both. Then the defect of the energy stays what it is; where the scheme merely errs, it falls with the order
p of the scheme,

    E(h / 2) = E(h) / 2^p

A body whose deflections are off by a part e under the same forces is as one with 1 / (1 + e) times its stiffness: a run with that tells
what the answers feel of it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from toolkit.analyses.run_start import known_start
from toolkit.analyses.transient import simulate
from toolkit.description.run_options import RunOptions
from toolkit.foundation.errors import ToolkitError
from toolkit.foundation.verdict import Caution
from toolkit.responses.motion import Displacement
from toolkit.scene.resolution import ResolvedScene
from toolkit.sensitivity.errors.step_cautions import VALUES
from toolkit.sensitivity.errors.step_error import LENIENT, Gradients, StepError, Values, first_order, shorter_steps
from toolkit.sensitivity.evaluation import evaluate_with_gradients
from toolkit.system.flexible_bodies import deforming, elastic_coordinates
from toolkit.system.renewal import softened
from toolkit.system.solution import Solution
from toolkit.validity.bodies.chains.known_chain import chain
from toolkit.validity.bodies.deformation import LIMIT
from toolkit.validity.description.mesh_cautions import bodies_of_stress
from toolkit.validity.motion.created_energy import energy_defects
from toolkit.validity.motion.motion import ENERGY

SLOWER = 1.5
"""Factor by which the energy defect may fall less than by the order: it is a maximum over time, and steps are not yet short."""

AT_MOST = 0.5
"""Relative error of deflections above which their effect on the answers is not estimated."""
UNCERTAIN = 2.0
"""The estimated errors of deflections may be too small by this factor."""

STILL = 1e-5
"""Displacement, relative to the model size, below which there is no caution."""


class Answers(NamedTuple):
    """Values and gradients of a run, and the scales of their errors."""

    values: Values
    gradients: Gradients
    scales: Mapping[str, float]
    slope_scales: Gradients


def unless_it_converges(
    cautions: Iterable[Caution], solution: Solution, error: StepError | None, measures: Mapping[str, Any]
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
        f"energy balance: {max(balance.values()):.1%} of the largest energy or work is gained or lost (limit {ENERGY:.0%}). The responses "
        "are not affected: with steps half as long this falls with the order of the scheme, and their estimated time-step error is "
        f"{max(error.values.values()):.1e} of their peaks.",
        doubt=False,
    )


def _converges(solution: Solution, error: StepError, balance: Mapping[str, float]) -> bool:
    """Whether values are known to be right, and no defect stays."""
    if not error.by_shorter_steps or not max(error.values.values(), default=0.0) <= VALUES:
        return False
    options = solution.options or solution.system.scene.solver
    try:
        halved = energy_defects(
            simulate(solution.system, shorter_steps(options, solution.whole_run, 2), known=known_start(solution))
        )
    except ToolkitError:
        return False
    allowed = SLOWER / 2 ** (1 if first_order(options) else 2)
    before = (balance["created"], balance["lost"])
    return all(now <= max(allowed * then, allowed * ENERGY) for now, then in zip(halved, before, strict=True))


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
    """Largest change of an answer where deflections are off by twice these parts; that of derivatives is divided by `LENIENT`."""
    asked = bodies_of_stress(solution.system.scene)
    known = max(parts.values()) <= AT_MOST and not asked & set(parts) and solution.run_times is None
    if not known or (answers.gradients and not solution.system.n_x):
        return LIMIT
    other = softened(solution.system, {body: 1 / (1 + UNCERTAIN * part) for body, part in parts.items()})
    try:
        values, gradients = evaluate_with_gradients(simulate(other, _same_steps(solution)))
    except ToolkitError:
        return LIMIT
    changes = [_part(float(np.real(values[f])) - value, answers.scales[f]) for f, value in answers.values.items()]
    slopes = [
        _part(gradients[f][x] - slope, max(abs(slope), answers.slope_scales[f][x])) / LENIENT
        for f, each in answers.gradients.items()
        for x, slope in each.items()
    ]
    return float(np.nan_to_num(max([*changes, *slopes], default=0.0), nan=np.inf))


def _part(change: float, scale: float) -> float:
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
            if scales[name] > 0 and off > max(LIMIT * scales[name], STILL * scene.size):
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
