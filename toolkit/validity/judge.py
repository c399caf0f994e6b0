"""The verdict on a solution: all checks that its states alone allow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from toolkit.foundation.processes.one_thread import one_thread
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.vibrations.flutter import unstable_vibrations
from toolkit.system.solution import Solution
from toolkit.validity.bodies.beam_assumptions import bent_between_nodes, energy_between_nodes
from toolkit.validity.bodies.bent_pieces import bent_pieces
from toolkit.validity.bodies.bent_surfaces import bent_surfaces
from toolkit.validity.bodies.chains.lines_on_bodies import lines_on_bodies
from toolkit.validity.bodies.chosen.outgrown_choices import outgrown_choices
from toolkit.validity.bodies.compressed.merging_vibrations import asked_vibrations, merging_vibrations
from toolkit.validity.bodies.compressed.parametric_resonance import parametric_resonance
from toolkit.validity.bodies.compressed.unseen_tension import unseen_tension
from toolkit.validity.bodies.fibres.fibre_stress import fibres_alone
from toolkit.validity.bodies.fibres.folded_skins import folded_skins
from toolkit.validity.bodies.physics import critical_loads, excessive_speeds, large_deformations, turning
from toolkit.validity.bodies.reduced.left_out_shapes import shapes_measured, shapes_missed
from toolkit.validity.bodies.reduced.missed_statics import missed_statics
from toolkit.validity.bodies.shear.sheared_deflections import sheared
from toolkit.validity.bodies.spinning.missing_stiffening import missing_stiffening
from toolkit.validity.bodies.spinning.partly_stiffened import partly_stiffened
from toolkit.validity.bodies.spinning.turns_in_a_step import turns_in_a_step
from toolkit.validity.bodies.tension.tension_cautions import tension
from toolkit.validity.bodies.tension.unseen_lines import unseen_lines
from toolkit.validity.curves.curve_overshoot import overshooting_tables
from toolkit.validity.curves.idle_curves import idle_curves
from toolkit.validity.curves.load_curves import unseen_curves
from toolkit.validity.description.frame_number import frames_chosen
from toolkit.validity.description.scene_cautions import cautions_of_scene
from toolkit.validity.equilibrium import limits_passed
from toolkit.validity.instabilities import unstable_motions
from toolkit.validity.motion.bushing_turns import bushings_turned_far
from toolkit.validity.motion.creeping_friction import creeping_friction, friction_at_rest
from toolkit.validity.motion.left_out import left_out
from toolkit.validity.motion.motion import coarse_steps, left_over, measured, unbalanced_energy
from toolkit.validity.motion.noisy_forces import noisy_forces
from toolkit.validity.motion.open_profiles import opened_profiles
from toolkit.validity.motion.snap_through import snap_through
from toolkit.validity.motion.spring_length import springs_through_zero
from toolkit.validity.start.start_cautions import cautions_of_start
from toolkit.validity.start.sudden_loads import halved_steps


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
    found = measures(solution)
    about_states = _of_states(solution, found) if solution.steps else unstable_vibrations(solution)
    return Verdict.of([*cautions(solution, found), *about_states], found)


def _of_states(solution: Solution, found: Mapping[str, Any]) -> Iterator[Caution]:
    yield from coarse_steps(solution)
    yield from noisy_forces(solution.options or solution.system.scene.solver, found["force_noise"])


def measures(solution: Solution) -> dict[str, Any]:
    """What is measured to judge a solution; of an equilibrium nothing but how well its joints are closed."""
    found = measured(solution) if solution.steps else {"drift": solution.drift}
    told = {"frames": frames_chosen(solution.system.scene), "left_out_shapes": shapes_measured(solution)}
    return {**found, **{name: each for name, each in told.items() if each}}


def cautions(solution: Solution, found: Mapping[str, Any]) -> Iterator[Caution]:
    """All cautions but those of coarse steps, noisy forces and growing vibrations: a result knows what they do to its numbers."""
    scene = solution.system.scene
    if solution.steps:
        yield from unbalanced_energy(solution, found["energy_balance"])
        yield from excessive_speeds(solution)
        yield from partly_stiffened(solution)
        yield from halved_steps(solution)
        yield from filter(None, [snap_through(solution)])
        yield from springs_through_zero(solution)
        yield from unseen_curves(solution)
        yield from idle_curves(solution)
        yield from overshooting_tables(solution)
        yield from creeping_friction(solution)
        yield from turns_in_a_step(solution)
        yield from left_out(solution)
        yield from unstable_motions(solution)
    else:
        yield from limits_passed(solution)
        if solution.spins:
            yield from excessive_speeds(solution)
            yield from missing_stiffening(solution)
        else:
            yield from friction_at_rest(solution)
    yield from bushings_turned_far(solution)
    yield from opened_profiles(solution)
    yield from lines_on_bodies(solution, asked_vibrations(solution))
    yield from cautions_of_start(solution)
    yield from cautions_of_scene(scene)
    yield from left_over(solution)
    yield from shapes_missed(solution)
    yield from large_deformations(solution)
    yield from bent_surfaces(solution)
    yield from outgrown_choices(solution)
    yield from bent_pieces(solution)
    yield from critical_loads(solution)
    yield from tension(solution)
    yield from merging_vibrations(solution)
    yield from parametric_resonance(solution)
    yield from unseen_tension(solution)
    yield from unseen_lines(solution)
    yield from sheared(solution)
    yield from folded_skins(scene)
    yield from bent_between_nodes(solution)
    yield from energy_between_nodes(solution)
    yield from missed_statics(solution)
    yield from fibres_alone(solution)
    yield from turning(solution)
    for body, names in scene.extrapolated().items():
        yield Caution(
            "extrapolated",
            f"bodies.{body} follows the tangent at its nominal design in {', '.join(names)}: an error of second order in the change.",
            doubt=False,
        )
