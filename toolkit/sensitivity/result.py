"""Result of an analysis: values and gradients of the responses, with the verdict whether to trust them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.balance.power import Power
from toolkit.responses.folded_rotations import folded_equilibria, folded_rotations
from toolkit.responses.forces.joint_force import JointForce
from toolkit.responses.magnitude import Largest, largest_in, magnitude_that_counts
from toolkit.responses.over_time.extremes import TimeKS, TimeMax, TimeMin
from toolkit.responses.over_time.loose_maxima import loose_maxima
from toolkit.responses.over_time.missed_peaks import missed_peaks
from toolkit.responses.over_time.over_time import OverTime
from toolkit.responses.over_time.tied_extremes import tied_extremes
from toolkit.responses.over_time.tied_stresses import tied_stresses
from toolkit.responses.vibrations.flutter import unstable_vibrations
from toolkit.responses.vibrations.growing import growing_vibrations
from toolkit.responses.vibrations.vibration import Frequency
from toolkit.scene.scene import Scene
from toolkit.sensitivity.errors.basis_errors import BasisErrors, Enriched, basis_errors, cautions_of_frozen
from toolkit.sensitivity.errors.lost_vibrations import lost_vibrations
from toolkit.sensitivity.errors.step_cautions import step_cautions
from toolkit.sensitivity.errors.step_error import Repeat, StepError, step_error
from toolkit.sensitivity.errors.unfelt_variables import unfelt_variables, without_false_zeros
from toolkit.sensitivity.errors.weighed_doubts import Answers, turned_displacements, unless_it_converges, unless_unfelt
from toolkit.sensitivity.frames.gradient_errors import (
    NONE,
    FrameErrors,
    Reframed,
    bodies_with_more,
    doubtful_gradients,
    doubtful_values,
    frame_errors,
    framed_doubts,
    unless_frames_deny,
)
from toolkit.sensitivity.preparation import moving, responses_of
from toolkit.sensitivity.sizes import variable_sizes
from toolkit.system.solution import Solution
from toolkit.validity.bodies.compressed.merging_vibrations import merging_vibrations
from toolkit.validity.bodies.frequencies import cautions_of_frequencies
from toolkit.validity.bodies.physics import critical_loads
from toolkit.validity.bodies.reduced.changed_vibrations import cautions_of_changed
from toolkit.validity.bodies.reduced.frozen_bases import frozen_bodies
from toolkit.validity.bodies.shear.sheared_vibrations import sheared_vibrations
from toolkit.validity.bodies.tension.steep_joints import steep_joints
from toolkit.validity.bodies.tension.stiffened_bodies import most_pulled
from toolkit.validity.bodies.tension.tension_cautions import tension
from toolkit.validity.curves.moved_curves import unseen_moves
from toolkit.validity.dead_points.cautions import dead_points_passed
from toolkit.validity.judge import cautions, measures
from toolkit.validity.motion.motion import SUSPICIOUS
from toolkit.validity.motion.noisy_forces import NOISY, JointNoise, noise_at, noise_of_joints, noise_of_values, noisy_forces

AROUND = 6
"""Number of states on both sides of the one that is asked for in which a force may alternate."""
UNIMPORTANT = 0.02
"""A derivative that changes its response by less than this part of its magnitude, where the variable changes by all of its size, is
compared with such a change instead of with itself."""


@dataclass(frozen=True)
class Result:
    """Values, units and gradients of the responses.

    Attributes
    ----------
    values
        Response -> its value.
    units
        Response -> label of its unit.
    gradients
        Response -> variable -> derivative; empty if none were asked for.
    method
        How gradients were found: "direct", "adjoint", a numerical method, or "none".
    solution
        The run that the numbers come from.
    wall_primal, wall_sensitivity
        Time of a run without gradients, and what these cost more, in s; None where nobody measured it, because that takes a run without
        gradients beside the one with them.
    reason
        Why the method was chosen, if nobody named one.
    repeat
        The same analysis with other options, which `verdict` needs.
    reframed
        The same analysis with other floating frames, which `verdict` needs where there are gradients.
    enriched
        The same analysis with more shapes in frozen bodies, which `verdict` needs away from their design and for gradients.
    """

    values: dict[str, Any]
    units: dict[str, str]
    gradients: dict[str, dict[str, float]]
    method: str
    solution: Solution
    wall_primal: float | None
    wall_sensitivity: float | None
    reason: str = ""
    repeat: Repeat | None = field(default=None, compare=False)
    reframed: Reframed | None = field(default=None, compare=False)
    enriched: Enriched | None = field(default=None, compare=False)

    @cached_property
    def measures(self) -> dict[str, Any]:
        """Measures of how exactly the states were found, see `toolkit.validity.judge.measures`."""
        return measures(self.solution)

    @cached_property
    def step_error(self) -> StepError | None:
        """Estimated time-step errors, measured by the same run with steps of another length when first asked for."""
        solution = self.solution
        if self.repeat is None or not moving(solution) or not self.values:
            return None
        suspicious = not max(self.measures["energy_balance"].values(), default=0.0) <= SUSPICIOUS
        known = self._answers
        responses = {name: each for name, each in responses_of(solution.system.scene).items() if name in self.values}
        lost = lost_vibrations(solution, responses, known.scales)
        return step_error(solution, self.values, self.gradients, known.scales, known.slope_scales, self.repeat, suspicious, lost)

    @cached_property
    def _answers(self) -> Answers:
        """Values and gradients of a motion, and the scales of their errors."""
        solution = self.solution
        responses = responses_of(solution.system.scene)
        largest = {name: largest_in(each, solution, self.values[name]) for name, each in responses.items()}
        scales = {name: magnitude_that_counts(each, solution, largest[name]) for name, each in responses.items()}
        return Answers(self.values, self.gradients, scales, self._slope_scales(scales, largest))

    def _slope_scales(self, scales: dict[str, float], found: dict[str, Largest]) -> dict[str, dict[str, float]]:
        """Scales of errors of derivatives: the largest in the motion, or a small effect of all of the variable."""
        scene, solution = self.solution.system.scene, self.solution
        sizes, counting = variable_sizes(scene, self) if self.gradients else {}, {}
        for f in found if sizes else ():
            largest = dict(zip(solution.system.design.names, found[f].slopes, strict=True))
            counting[f] = {
                x: max(largest.get(x, 0.0), UNIMPORTANT * scales[f] / size if size else 0.0) for x, size in sizes.items()
            }
        return counting

    @cached_property
    def frame_errors(self) -> FrameErrors | None:
        """Estimated errors by the number of floating frames, by a run with more of them when first asked for."""
        if self.reframed is None or not self.gradients:
            return None
        return frame_errors(self.solution, self.values, self.gradients, self.scales, self.reframed)

    @cached_property
    def basis_errors(self) -> BasisErrors | None:
        """Errors by frozen bases, by the same analysis with more shapes when first asked for; None without frozen bases."""
        if self.enriched is None or not self.values:
            return None
        scene, variables = self.solution.system.scene, next(iter(self.gradients.values()), {})
        bodies = frozen_bodies(scene, variables)
        if not bodies:
            return None
        scales, slopes = self._answers[2:] if moving(self.solution) else (self._undecided, {})
        return basis_errors(
            bodies,
            {f: (value, scales[f]) for f, value in self.values.items()},
            {f: {x: (slope, slopes[f][x] if slopes else 0.0) for x, slope in row.items()} for f, row in self.gradients.items()},
            variable_sizes(scene, self) if variables else {},
            self.enriched,
        )

    @property
    def gradient_scales(self) -> Mapping[str, Mapping[str, float]]:
        """Response -> variable -> the largest gradient in the motion, which errors of gradients are compared with; empty in statics."""
        return self._answers.slope_scales if moving(self.solution) else {}

    @property
    def _undecided(self) -> dict[str, float]:
        """Uncertainty that Newton's method leaves in the values of a state at rest, by response."""
        responses = responses_of(self.solution.system.scene, moving=False)
        return {f: magnitude_that_counts(each, self.solution, NONE) for f, each in responses.items()}

    @cached_property
    def verdict(self) -> Verdict:
        """Whether values and gradients can be trusted, and why not; found when first asked for.

        That costs half a run, one with more floating frames where there are gradients of bodies that deform far, and one with
        more shapes where bases are frozen.
        """
        found, errors = self._verdict, self.weighed_frames
        if self.gradients and self.solution.system.n_x and (errors is None or most_pulled(self.solution) not in errors.frames):
            found = Verdict.of([*found.warnings, *steep_joints(self.solution)], found.measures)
        if self.basis_errors is not None:
            about_bases = {**found.measures, "frozen_basis": self.basis_errors.record()}
            found = Verdict.of([*found.warnings, *cautions_of_frozen(self.basis_errors)], about_bases)
        if errors is None:
            return found
        sizes = variable_sizes(self.solution.system.scene, self)
        scales, slopes = self.scales, self.gradient_scales
        weighed = unless_frames_deny(found.warnings, self.solution, errors, scales, self.gradients, sizes, slopes)
        doubts = (*doubtful_values(errors, scales), *doubtful_gradients(errors, self.gradients, sizes, slopes))
        record = errors.record(self.gradients, sizes, slopes)
        return Verdict.of([*weighed, *doubts], {**found.measures, "geometric_error": record})

    @property
    def scales(self) -> Mapping[str, float]:
        """Response -> the largest value in a motion, which errors by frames are compared with; without a motion its value."""
        return self._answers.scales if moving(self.solution) else {f: abs(value) for f, value in self.values.items()}

    @cached_property
    def weighed_frames(self) -> FrameErrors | None:
        """Errors by the number of frames, with bodies that are doubted among those that are given more."""
        bodies = framed_doubts(self._verdict.warnings)
        if self.reframed is None or not self.gradients or bodies <= set(bodies_with_more(self.solution)):
            return self.frame_errors
        return frame_errors(self.solution, self.values, self.gradients, self.scales, self.reframed, bodies)

    @cached_property
    def _verdict(self) -> Verdict:
        """The verdict without the effects of frames and frozen bases on gradients."""
        if self.repeat is None or not moving(self.solution) or not self.values:
            found = self.solution.verdict
            folded = folded_equilibria(self.solution) if self.values and not self.solution.steps else ()
            loose = loose_maxima(self.solution) if self.values else ()
            of_state = set(unstable_vibrations(self.solution))  # said again by what was asked for
            others = [each for each in found.warnings if each not in of_state]
            tied = tied_stresses(self.solution) if self.gradients else ()
            every = [*others, *self._of_vibrations(), *folded, *loose, *tied, *self._undefined()]
            return Verdict.of(without_false_zeros(every), found.measures)
        measured, options = dict(self.measures), self.solution.options or self.solution.system.scene.solver
        about_steps = step_cautions(self.step_error, self.values, self.gradients, options)
        if self.step_error is not None:
            estimated = {
                "how": self.step_error.how,
                "relative_to": "the largest magnitude in the motion",
                "responses": self.step_error.values,
                "gradients": self.step_error.gradients,
            }
            measured["estimated_error"] = {**measured["estimated_error"], **estimated}
        about_forces = force_cautions(self.solution, measured["force_noise"], self._answers.scales)
        variables = next(iter(self.gradients.values()), {})
        about_responses = (
            *about_forces,
            *about_steps,
            *unseen_moves(self.solution, variables),
            *dead_points_passed(self.solution, variables),
            *folded_rotations(self.solution),
            *missed_peaks(self.solution),
            *turned_displacements(self.solution, self.values, self._answers.scales),
            *loose_maxima(self.solution),
            *tied_extremes(self.solution),
            *tied_stresses(self.solution),
            *self._undefined(),
            *self._of_vibrations(),
        )
        about_states = unless_it_converges(cautions(self.solution, measured), self.solution, self.step_error, self.measures)
        about_states = unless_unfelt(about_states, self.solution, self._answers)
        return Verdict.of(without_false_zeros([*about_states, *about_responses]), measured)

    @property
    def warnings(self) -> tuple[Caution, ...]:
        """All cautions of the verdict, doubts first."""
        return self.verdict.warnings

    def _of_vibrations(self) -> Iterator[Caution]:
        """Cautions about vibrations that too long elements or left-out shapes change, or that are stiffened or grow."""
        scene = self.solution.system.scene
        responses = {f: each for f, each in scene.responses.items() if f in self.values}
        asked = {f: self.values[f] for f, each in responses.items() if isinstance(each, Frequency)}
        yield from cautions_of_frequencies(self.solution, asked, doubt=True, differentiated=bool(self.gradients))
        yield from sheared_vibrations(self.solution, asked, bool(self.gradients))
        yield from cautions_of_changed(self.solution)
        yield from growing_vibrations(self.solution, self.values)
        if self.gradients and not self.solution.system.n_x:
            yield from critical_loads(self.solution, lateral=True)  # what its derivatives feel is not known
            yield from tension(self.solution, lateral=True)
            yield from merging_vibrations(self.solution, lateral=True)

    def _undefined(self) -> Iterator[Caution]:
        """Remarks on values and derivatives that do not exist at this design, and on variables that nothing feels."""
        yield from unfelt_variables(self.gradients)
        numbers = {f"the value of {name}": value for name, value in self.values.items()}
        numbers |= {f"the derivative of {f} by {x}": slope for f, slopes in self.gradients.items() for x, slope in slopes.items()}
        for what, number in numbers.items():
            if not np.isfinite(number):
                yield Caution("undefined", f"{what} does not exist at this design; it is nan, in JSON null.", doubt=False)


def result(
    scene: Scene,
    solution: Solution,
    values: dict[str, Any],
    gradients: dict[str, dict[str, float]],
    method: str,
    primal: float | None,
    extra: float | None,
    repeat: Repeat | None = None,
) -> Result:
    """A result with the units of its responses; arguments as the fields of `Result`."""
    units = {name: response.unit(scene.units) for name, response in responses_of(scene, moving(solution)).items()}
    return Result(
        {name: float(np.real(value)) for name, value in values.items()},
        units,
        gradients,
        method,
        solution,
        primal,
        extra,
        repeat=repeat,
    )


def force_cautions(solution: Solution, noise: Mapping[str, Any], sizes: Mapping[str, float]) -> Iterator[Caution]:
    """Cautions about noisy joint forces: a doubt where a response is such a force at its time, otherwise a remark.

    The noise is that of `force_noise`, sizes are the largest that responses are.
    """
    scene = solution.system.scene
    if not noise or noise["size"] <= NOISY:
        return
    joints = noise_of_joints(solution)
    noisy = [name for name, each in scene.responses.items() if _noise_in(each, joints, solution, sizes.get(name, 0.0)) > NOISY]
    quiet = [name for name, each in scene.responses.items() if name not in noisy and _largest_noise(each, joints) > NOISY]
    yield from noisy_forces(solution.options or scene.solver, noise, noisy, quiet)


def _largest_noise(response: Any, joints: Mapping[str, JointNoise]) -> float:
    """Noise at any time in the joint's force that a response is made of, as a part of the joint's largest force."""
    looked = response.source if isinstance(response, OverTime) else response
    joint = looked.joint if isinstance(looked, JointForce | Power) else None
    return 0.0 if joint is None else float(joints[joint].noise.max())


def _noise_in(response: Any, joints: Mapping[str, JointNoise], solution: Solution, size: float) -> float:
    """Noise in a response that is a joint's force or a driver's power, relative to the largest.

    It is that at the response's time, or of an extreme over time at any. Means do not feel what alternates. It is a part of the
    joint's largest force, or of the largest that the response itself is, whichever is less.
    """
    extreme = isinstance(response, TimeMax | TimeMin | TimeKS)
    looked = response.source if extreme else response
    joint = looked.joint if isinstance(looked, JointForce | Power) else None
    if joint is None:
        return 0.0
    last, step = len(solution.times) - 1, 0 if extreme else looked.step(solution)
    found = float(joints[joint].noise.max()) if extreme else noise_at(joints[joint], step)
    if found <= NOISY:
        return found
    states = np.arange(last + 1) if extreme else np.arange(max(step - AROUND, 0), min(step + AROUND, last) + 1)
    look = looked.instants(solution)
    values = np.array([float(np.real(look(int(n)).value)) for n in states])
    return min(found, noise_of_values(values, solution.times[states], size))
