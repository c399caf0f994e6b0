"""Options for solving a scene; every number can be overridden by its path."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from toolkit.description.description import Description, NotNegative, Positive, Quantity
from toolkit.foundation.errors import InputError
from toolkit.foundation.files.safe_files import file_name

LARGEST_RHO_INDEX_3, LARGEST_RHO_CHANGING_STEPS = 0.8, 0.5
"""Largest rho_inf of index 3, and with steps of changing length. Nothing but the scheme damps errors of joint forces there, and curved
paths feed them: they grow from step to step unless a turn has 14, 19, 26, 42, 88 steps at rho_inf = 0.5, 0.6, 0.7, 0.8, 0.9, and with 1
always. What has grown is told by `validity.noisy_forces`."""
STEEPEST_STEP_CHANGE = 100.0
"""Shrinking from step to step up to which index 3 and stabilised index 2 are right."""

STARTS, RESULTS = ("given", "equilibrium"), ".h5"
"""Words for a start, and the end of the name of a results file that is one."""
START_SCHEMA = {"anyOf": [{"enum": list(STARTS)}, {"type": "string", "pattern": r"\.h5$"}]}


def known_start(value: str) -> str:
    """Refuse a start that is neither a word nor the name of a results file."""
    if value not in STARTS and not value.endswith(RESULTS):
        raise ValueError(
            f"{value!r} is no start: write {' or '.join(map(repr, STARTS))}, or the name of a results file, which ends in {RESULTS}"
        )
    return file_name(value)


def contradictions(options: RunOptions) -> Iterator[str]:
    """Sentences on options that contradict each other, one for each contradiction."""
    if options.times is not None:
        yield from _of_times(options, options.times)
    if options.scheme == "paper" and (options.local_error is not None or options.formulation != "index-1"):
        yield (
            'scheme = "paper" is of index 1, and has no estimate of its local error; take scheme = "arnold-bruels", or leave out '
            "formulation and local_error"
        )
    if options.quasi_static and options.formulation == "ggl":
        yield (
            'formulation = "ggl" closes the joints by velocities too, which a quasi-static run does not solve for; leave out one of '
            "formulation and quasi_static (a quasi-static run closes them by positions)"
        )
    if options.equilibrium == "spinning" and options.continuation == "arc-length":
        yield 'the steady state of a spin is not followed by arc length; leave out one of equilibrium = "spinning" and continuation'
    if options.equilibrium == "spinning" and options.quasi_static:
        yield (
            "the steady state of a spin is held by inertia, which a quasi-static run leaves out; leave out one of "
            'equilibrium = "spinning" and quasi_static'
        )
    if options.quasi_static and options.start_file is not None:
        yield (
            "a quasi-static run begins in the equilibrium at time 0, so that start can name no results file; leave out one of start and "
            "quasi_static"
        )
    if options.redundant == "least-squares" and options.formulation == "ggl":
        yield (
            'formulation = "ggl" closes every joint twice and cannot leave redundant ones out; take index-1 or index-3, or '
            'redundant = "refuse"'
        )
    changing = options.times is not None or options.local_error is not None
    most = LARGEST_RHO_CHANGING_STEPS if changing else LARGEST_RHO_INDEX_3
    if options.formulation == "index-3" and options.rho_inf > most:
        yield (
            f'formulation = "index-3"{" with steps of changing length" * changing} needs rho_inf of at most {most:g}: nothing else '
            "damps errors of its joint forces, which grow from step to step where bodies turn, while the motion still looks right; take a "
            "smaller rho_inf, or index-1 or ggl"
        )


def _of_times(options: RunOptions, times: tuple[float, ...]) -> Iterator[str]:
    lengths = [b - a for a, b in pairwise(times)]
    if min(lengths) <= 0 or times[0] != 0 or times[-1] != options.end_time:
        yield f"times must increase from 0 to end_time = {options.end_time:g}; fix them, or leave times out"
    elif options.formulation != "index-1" and any(a > STEEPEST_STEP_CHANGE * b for a, b in pairwise(lengths)):
        yield (
            f"times hold a step that is more than {STEEPEST_STEP_CHANGE:g} times shorter than the one before: what that left "
            "of the joints' velocities would be a blow; let steps shrink gradually, or take index-1"
        )
    if options.local_error is not None:
        yield "times are given, so that local_error has nothing to choose; leave one of them out"


Count = Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
Halvings = Annotated[int, Field(strict=True, ge=0, le=20), Quantity("none")]
Seed = Annotated[int, Field(strict=True, ge=0)]
Formulation = Literal["index-1", "index-3", "ggl"]


class Baumgarte(Description):
    """Constraint stabilization Phi'' + 2 damping Phi' + stiffness^2 Phi = 0; by default damping = 1/step, stiffness = sqrt(2)/step.

    Attributes
    ----------
    damping
        In 1/time; by default 1/step.
    stiffness
        In 1/time; by default sqrt(2)/step.
    """

    damping: Annotated[NotNegative | None, Quantity("1/time")] = None
    stiffness: Annotated[NotNegative | None, Quantity("1/time")] = None


class RunOptions(Description):
    """Options of transient and static analysis.

    Attributes
    ----------
    end_time
        Time at which the run ends; it begins at 0.
    step
        Time step; at most this, so that the end is hit exactly.
    scheme
        "arnold-bruels" is of second order for every rho_inf, "paper" (weights of its eqs. 16-23) of first order for rho_inf < 1.
    rho_inf
        Spectral radius at infinite frequency: 1 keeps all energy, 0 annihilates what a step cannot resolve.
    formulation
        How joints are kept closed. "index-1": by their accelerations and Baumgarte's stabilization, the cheapest; they stay closed to
        about the square of the step. "index-3": by their positions, to round-off; joint forces get noisy at tiny steps,
        and where bodies turn far in a step: with rho_inf = 0.5 a turn needs 14 steps, with 0.8, the largest, 42.
        "ggl": by positions and by velocities, to round-off both (stabilised index 2 of Gear, Gupta and Leimkuhler), with quiet joint
        forces for every rho_inf and every step of equal length; a step costs about twice as much, and the adjoint cannot do it.
    baumgarte
        Stabilization of the joints in index 1. The defaults let a gap die out within a few steps, whatever the step.
    tolerance
        Newton stops when a correction moves nothing by more than this part of the model size (or this angle in rad), or before if by what
        its last corrections have left no more than 1e-15 of the size is left.
    newton
        "full" makes a new Jacobian in every step, and for every further correction unless the last one has hardly changed it; "modified"
        keeps its factors, from step to step, as long as an iteration shrinks the correction to a fifth. It takes two or three times the
        iterations, each without factoring: cheaper where factoring is dear, from some tens of coordinates on. What they leave is bounded
        over the whole run: motion and gradients differ from those of "full" by some hundred times `tolerance` at every step, unless a
        singular position makes more of it.
    max_iterations
        Newton iterations after which a step has failed.
    halvings
        How often a step in which Newton does not converge may be halved; the run tells which ones were. With 0, and without inertia, such
        a step ends the run. A run that chooses its steps shortens them anyway.
    quasi_static
        Whether inertia is left out, so that the motion is a sequence of equilibria (with the forces of dampers). Needs an equilibrium at
        time 0, and refuses to jump where the path of equilibria ends. Without dampers the path is followed between two times where
        the states do not show it, and unstable equilibria are refused.
    start
        Where a motion begins: "given", in the written positions and shapes; "equilibrium", in the equilibrium under the loads that
        act at time 0, with the velocities that the scene writes, or with `equilibrium` = "spinning" in the steady spin that its driver
        asks for then; or "wing.h5", in the last state of the run that this results file keeps,
        whose positions, shapes and velocities replace the written ones; it is sought from the scene's folder. Time begins at 0 again,
        and so do curves (give those that go on a negative `start`) and in space counted turns. Gradients know how an equilibrium depends on
        the design, and how a kept state does if the file holds its derivatives (`ffrf sensitivity --method direct --output`); without
        them, gradients by numbers that the kept run had too are refused.
    local_error
        Error that a step may make, a part of the model size (or rad): the run then chooses its steps, at most `step`, hits every corner
        of a load curve and every time that a response names, and gradients are those of the steps that it chose.
    times
        Times of the run, instead of equal steps: from 0 to `end_time`. An adaptive run can be repeated with the times it chose.
    load_steps
        How many steps of the load a static analysis takes where its path is straight. Where it bends, or nearly loses its stability, steps
        are shortened until nothing can hide between them.
    drift_tolerance
        A run whose joints open by more than this part of the model size (or rad) is refused.
    assemble
        Whether a transient run first closes joints that are open in the given positions, by moving the bodies as little as possible
        (measured by the mass matrix). Without it they are an error. With it lengths, offsets and start values of drivers can be
        design variables: the bodies follow. Statics always closes the joints.
    redundant
        What to do with joints that repeat each other (a door on two hinges): "refuse" and name them, or "least-squares": constraints that
        others imply at the start are left out of the motion, and joint forces are those of least squares among all that fit.
    memory
        GB that the states of a run may take. Beyond it, the adjoint keeps checkpoints and computes the rest twice; other methods
        refuse.
    continuation
        How statics follows the path of equilibria: "load" up to the first limit point (snap-through), where it stops with an error;
        "arc-length" past limit points, to the first stable equilibrium under the full load, and it says which ones it passed.
    path_steps
        Most steps along the path of equilibria in statics.
    equilibrium
        What statics finds: "rest", the equilibrium of a scene that does not move; or "spinning", the steady state of a scene that an
        angle-driver between a body and the ground spins as a whole, with its rate at the end time. Bodies deform under their own
        inertia then, stay as they are in a frame that spins with them, and modes and frequencies are those about this state.
    """

    end_time: Annotated[Positive, Quantity("time")] = 1.0
    step: Annotated[Positive, Quantity("time")] = 0.01
    scheme: Literal["arnold-bruels", "paper"] = "arnold-bruels"
    formulation: Formulation = "index-1"
    rho_inf: Annotated[float, Field(strict=True, ge=0, le=1), Quantity("none")] = 0.5
    baumgarte: Baumgarte = Baumgarte()
    tolerance: Annotated[float, Field(strict=True, gt=1e-14, lt=1e-2), Quantity("none")] = 1e-10
    newton: Literal["full", "modified"] = "full"
    max_iterations: Count = 20
    halvings: Halvings = 10
    quasi_static: bool = False
    start: Annotated[str, AfterValidator(known_start), WithJsonSchema(START_SCHEMA)] = "given"
    local_error: Annotated[Positive | None, Quantity("none")] = None
    times: Annotated[tuple[NotNegative, ...] | None, Quantity("time")] = Field(default=None, min_length=2)
    load_steps: Count = 10
    drift_tolerance: Annotated[Positive, Quantity("none")] = 1e-3
    assemble: bool = False
    redundant: Literal["refuse", "least-squares"] = "refuse"
    memory: Annotated[Positive, Quantity("none")] = 8.0
    continuation: Literal["load", "arc-length"] = "load"
    path_steps: Count = 1000
    equilibrium: Literal["rest", "spinning"] = "rest"

    @property
    def start_file(self) -> str | None:
        """Results file that a motion begins from, None if it begins elsewhere."""
        return None if self.start in STARTS else self.start

    @model_validator(mode="after")
    def _fit_together(self) -> RunOptions:
        for sentence in contradictions(self):
            raise ValueError(sentence)
        return self


MOST_STEPS = 100_000_000
EQUAL_STEPS_TOLERANCE = 1e-9
"""Relative difference of step lengths that is round-off of the times."""


def time_grid(options: RunOptions) -> np.ndarray:
    """Given times, or equal steps from 0 to the end time, (n_t,).

    The end is hit exactly, so equal steps are at most as long as the one that was asked for. A run with error control chooses its times
    as it goes; this is the coarsest that it could choose.

    Raises
    ------
    InputError
        The step is larger than the end time, or so small that the states cannot be kept.
    """
    if options.times is not None:
        return np.array(options.times, float)
    steps = np.ceil(options.end_time / options.step * (1 - 1e-9))
    if options.step > options.end_time * (1 + 1e-9):
        raise InputError(
            f"solver.step = {options.step:g} is larger than solver.end_time = {options.end_time:g}. "
            "Choose a step that resolves the motion, for example a twentieth of the load's rise time."
        )
    if steps > MOST_STEPS:
        raise InputError(
            f"solver.step = {options.step:g} makes {steps:.3g} steps until solver.end_time = {options.end_time:g}, more than can be "
            f"kept ({MOST_STEPS:g}). Choose a larger step or a shorter time."
        )
    return np.linspace(0.0, options.end_time, int(steps) + 1)


def step_lengths(times: np.ndarray) -> np.ndarray:
    """Lengths of all steps, (n_t - 1,); exactly the same ones if they differ by round-off only."""
    lengths = np.diff(times)
    return (
        np.full_like(lengths, lengths[0])
        if np.all(np.abs(lengths - lengths[0]) <= EQUAL_STEPS_TOLERANCE * lengths[0])
        else lengths
    )
