"""Options for solving a scene; every number can be overridden by its path."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from toolkit.description.description import Description, NotNegative, Positive
from toolkit.description.option_checks import START_SCHEMA, STARTS, contradictions, known_start
from toolkit.description.quantity import Quantity

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
