"""The verdict on a solution: all checks that its states alone allow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from toolkit.foundation.processes import one_thread
from toolkit.foundation.value_types import Scalar
from toolkit.foundation.verdict import MOTION, REST, SPIN, Caution, Check, Verdict, check, checks
from toolkit.responses.flutter import UNSTABLE, growing_vibrations, unstable_vibrations
from toolkit.system.solution import Solution
from toolkit.validity.bodies.missed_statics import shapes_measured
from toolkit.validity.equilibrium import stays_in_unstable
from toolkit.validity.frame_choice import frames_chosen
from toolkit.validity.motion import Measures, measured
from toolkit.validity.scene_cautions import cautions_of_scene
from toolkit.validity.undisturbed import middle_spins, undisturbed


@one_thread()
def judge(solution: Solution) -> Verdict:
    """Whether the states of a solution can be trusted, and why not.

    A motion is judged by its energy and its steps, an equilibrium by the path that leads there, both by what the model leaves out. What
    the length of the steps does to a response is not in it: the `verdict` of a `sensitivity.run.Run` measures it.

    Parameters
    ----------
    solution : Solution
        Of `simulate` or `solve_statics`, with real numbers.
    """
    about_states = [caution for each in _applicable(solution) if each.by_result for caution in each(solution)]
    return Verdict.of([*cautions(solution), *about_states], measures(solution))


def measures(solution: Solution) -> Measures:
    """What is measured to judge a solution; of an equilibrium nothing but how well its joints are closed."""
    found: Measures = {**measured(solution)} if solution.steps else {"drift": solution.drift}
    if frames := frames_chosen(solution.system.scene):
        found["frames"] = frames
    if left_out := shapes_measured(solution):
        found["left_out_shapes"] = left_out
    return found


def cautions(solution: Solution) -> Iterator[Caution]:
    """All cautions but those of coarse steps, noisy forces and growing vibrations: a result knows what they do to its numbers."""
    for each in _applicable(solution):
        if not each.by_result:
            yield from each(solution)
    yield from cautions_of_scene(solution.system.scene)


def _applicable(solution: Solution) -> list[Check[[Solution]]]:
    """Checks of solutions of this kind."""
    kind = MOTION if solution.steps else SPIN if solution.spins else REST
    return [each for each in checks() if kind in each.applies_to]


def instabilities(solution: Solution, values: Mapping[str, Scalar]) -> Iterator[Caution]:
    """Cautions about equilibria, motions and vibrations that a small disturbance ends: every design of a map is checked for them by itself.

    Growth hangs on small differences, and its effect is exponential.

    Parameters
    ----------
    values
        Response -> value; vibrations are looked at where they are asked for.
    """
    for each in _applicable(solution):
        if each.each_design:
            yield from each(solution)
    yield from growing_vibrations(solution, values)


def codes_of_instabilities() -> frozenset[str]:
    """Codes of the cautions that `instabilities` finds."""
    return frozenset(each.code for each in checks() if each.each_design)


@check(UNSTABLE, (MOTION,), each_design=True)
def unstable_motions(solution: Solution) -> Iterator[Caution]:
    """Motions that hold only because nothing disturbs them."""
    yield from [*middle_spins(solution), *stays_in_unstable(solution)] or undisturbed(solution)


@check(UNSTABLE, (REST, SPIN), by_result=True)
def unstable_states(solution: Solution) -> Iterator[Caution]:
    """Vibrations of an equilibrium or a spin that grow."""
    yield from unstable_vibrations(solution)
