"""A scene that is compiled once and analysed many times, at its own numbers or at others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from toolkit.analyses.modes import Campbell, Modes, solve_modes
from toolkit.analyses.modes import campbell as campbell_of
from toolkit.analyses.modes import undeformed as at_rest
from toolkit.analyses.sensitivity.compiled import Compiled
from toolkit.analyses.sensitivity.errors.basis_errors import cautions_of_frozen, frequency_errors
from toolkit.analyses.sensitivity.preparation import Kind, Progress, check_kind, check_names, solve
from toolkit.analyses.sensitivity.run import Run
from toolkit.api.outcome import Outcome, analysed, check_method, outcomes
from toolkit.components.loads.gravity import UniformGravity
from toolkit.foundation.errors import InputError
from toolkit.foundation.verdict import Caution, Verdict
from toolkit.responses.flutter import UNSTABLE
from toolkit.scene.scene import Scene
from toolkit.studies.executor import Executor
from toolkit.system.evaluation import refuse_changed
from toolkit.system.solution import Solution

FREE = Caution(
    "free-modes",
    "no joint holds a body and no load but weight acts: these are modes about the given positions, and frequencies of zero are rigid "
    "motions.",
    doubt=False,
)
"""Caution about the modes of bodies that float."""


def compile_model(scene: Scene, variables: Sequence[str] = ()) -> Model:
    """Make a scene ready to be analysed.

    Parameters
    ----------
    scene
        What `read_scene` has returned, or a scene made in Python.
    variables
        Design variables that gradients are wanted by: short names that the scene declares, or paths of its numbers. The numbers of an
        analysis can be changed whether they are variables or not.

    Returns
    -------
    model
        The compiled scene; what an analysis needs is compiled when it is first asked for.

    Raises
    ------
    InputError
        A variable is unknown; lists those that are possible.

    Examples
    --------
    >>> model = ffrf.compile(ffrf.read_scene("wing.toml"), variables=["t_w"])
    >>> model.statics({"t_w": 1.6}, gradients=True).gradients["max_stress"]["t_w"]
    """
    if not isinstance(scene, Scene):
        raise InputError(f"compile takes a scene, not {scene!r}. Read one: ffrf.read_scene(path).")
    if not isinstance(variables, Iterable):
        raise InputError(f"variables are a list of names, not {variables!r}. Leave them out, or write variables=[...].")
    names = variables if isinstance(variables, str) else tuple(variables)
    check_names(names)
    compiled = Compiled(scene, tuple(names))
    _ = compiled.files, compiled.design  # refuses unknown names now, not when the first gradient is wanted
    return Model(compiled)


class Model:
    """A compiled scene with its design variables; `compile` makes one.

    Every analysis takes other numbers by short name or path, and renews only what they touch. Nothing is measured twice: an analysis solves
    the scene once.

    Parameters
    ----------
    compiled
        The scene, compiled with and without its variables as far as that was needed.
    """

    def __init__(self, compiled: Compiled) -> None:
        self._compiled = compiled

    @property
    def scene(self) -> Scene:
        """Scene at its own numbers."""
        return self._compiled.scene

    @property
    def variables(self) -> dict[str, float]:
        """Design variables and their values in the scene."""
        return dict(self._compiled.design.values)

    def at(self, numbers: Mapping[str, float]) -> Model:
        """Model at other numbers of the scene.

        Parameters
        ----------
        numbers
            Short name or path of a number of points, bodies, joints, loads or of the solver -> its value.

        Returns
        -------
        model
            Another model, which shares what the numbers do not touch. If a value changes from
            zero, the sparsity pattern may grow and the scene is compiled anew.

        Raises
        ------
        InputError
            There is no such number, or its value is invalid.
        """
        if isinstance(numbers, Mapping) and not numbers:
            return self
        return Model(self._compiled.at(numbers))

    def simulate(
        self,
        numbers: Mapping[str, float] | None = None,
        *,
        gradients: bool | str = False,
        start: Run | None = None,
        progress: Progress | None = None,
        timed: bool = False,
    ) -> Run:
        """Integrate the scene over time.

        Parameters
        ----------
        numbers
            Other numbers for this run, see `at`.
        gradients
            Whether gradients by the model's variables are wanted; or the method: "direct", "adjoint", "auto" (the cheaper one of these),
            "complex-step", "forward-difference", "central-difference".
        start
            A run whose last state the motion begins in, with its velocities; it does not depend on the design then. Time begins at 0 again,
            and so do all time curves.
        progress
            Called with the steps done and the steps in all.
        timed
            Whether to repeat a short run until its price is known, without gradients and with them: `Run.wall_primal` and
            `Run.wall_sensitivity` in s.

        Returns
        -------
        run
            Values, gradients, verdict and states.

        Raises
        ------
        InputError
            A number or a word is wrong.
        ConvergenceError, SingularSystemError
            The motion cannot be integrated; names time, equation and remedy.
        """
        return analysed(self._at(numbers), "transient", gradients, start, progress, timed)

    def statics(
        self,
        numbers: Mapping[str, float] | None = None,
        *,
        gradients: bool | str = False,
        start: Run | None = None,
        progress: Progress | None = None,
        timed: bool = False,
    ) -> Run:
        """Find the equilibrium under the loads at the end time, along the path from the unloaded state.

        Parameters
        ----------
        numbers, gradients, progress, timed
            As of `simulate`.
        start
            An equilibrium of the same scene at other numbers, to begin in: saves the way from the unloaded state where a stable equilibrium
            is close by, and says so in the verdict.

        Returns
        -------
        run
            Values of the responses that a state at rest has, gradients, verdict and the state.

        Raises
        ------
        InputError
            A number or a word is wrong.
        LimitPointError, BifurcationError
            The path turns back before the full load (snap-through), or becomes unstable (buckling).
        ConvergenceError, SingularSystemError
            There is no equilibrium, or something is free to move.
        """
        return analysed(self._at(numbers), "static", gradients, start, progress, timed)

    def modes(
        self,
        numbers: Mapping[str, float] | None = None,
        *,
        count: int = 10,
        undeformed: bool = False,
        spinning: bool = False,
        progress: Progress | None = None,
    ) -> Modes:
        """Eigenfrequencies and mode shapes about the equilibrium under the loads at the end time, or about a steady spin.

        Parameters
        ----------
        numbers
            Other numbers, see `at`.
        count
            How many, from the lowest.
        undeformed
            About the given positions instead, for example of a free body. They are taken anyway, and the verdict says so, where no joint
            holds a body and no load but its weight acts.
        spinning
            About the steady state of a scene that its driver spins, with centrifugal and gyroscopic forces and dampers, whatever
            `solver.equilibrium` says; frequencies are those that the frame sees which spins with the scene.
        progress
            Called with the load steps done and the load steps in all.

        Returns
        -------
        modes
            `frequencies` in 1/time, ascending, `shapes` (n_q, count), `verdict`, and about a spin `damping`.

        Raises
        ------
        InputError, ConvergenceError, SingularSystemError
            As `statics`; or nothing can move.
        """
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise InputError(f"count = {count!r}: give a whole number of modes, at least one.")
        refuse_changed(self._compiled.files)
        if undeformed and spinning:
            raise InputError(
                "modes are about the given positions or about a steady spin. Leave out one of undeformed and spinning."
            )
        compiled = self._at(numbers)
        found = self._modes_of(compiled, count, undeformed, spinning, progress)

        def enriched() -> dict[str, float]:
            return _named(self._modes_of(compiled.enriched(), count, undeformed, spinning).frequencies)

        about_bases = cautions_of_frozen(frequency_errors(compiled.scene, _named(found.frequencies), enriched))
        return found._replace(verdict=Verdict.of([*about_bases, *found.verdict.warnings]))

    def _modes_of(
        self, compiled: Compiled, count: int, undeformed: bool, spinning: bool, progress: Progress | None = None
    ) -> Modes:
        """Modes without cautions about frozen bases."""
        floating = not (undeformed or spinning) and _floats(self.scene)
        as_given = undeformed or floating
        system = (compiled.of_one_frame() if as_given else compiled.analysed_by("static")).primal
        options = system.scene.solver.model_copy(update={"equilibrium": "spinning"}) if spinning else None
        state = _without_responses(at_rest(system) if as_given else solve(system, "static", progress, options))
        found = solve_modes(state, count)
        told = [FREE] if floating else []
        codes = found.verdict.codes
        once = {
            "critical-load": True,
            "tension": "tension" in codes,
            UNSTABLE: "unstable" in codes,
        }  # said of the modes themselves
        of_state = [each for each in state.verdict.warnings if not once.get(each.code)]
        return found._replace(verdict=Verdict.of([*told, *found.verdict.warnings, *of_state]))

    def campbell(
        self,
        speeds: Sequence[float],
        numbers: Mapping[str, float] | None = None,
        *,
        count: int = 6,
        progress: Progress | None = None,
    ) -> Campbell:
        """Frequencies and damping of the steady spin at several speeds: Campbell's diagram.

        Parameters
        ----------
        speeds
            In rad/time, instead of that of the driver which spins the scene.
        numbers
            Other numbers, see `at`.
        count
            How many frequencies, from the lowest.
        progress
            Called with the speeds done and the speeds in all.

        Returns
        -------
        campbell
            `speeds` (n,), `frequencies` in 1/time and `damping` (n, count), in the frame that spins, and `verdict`.

        Raises
        ------
        InputError
            Nothing spins the scene, or it does not spin as a whole, or is not the same at every angle.
        ConvergenceError, SingularSystemError
            There is no steady state at a speed, which is named.
        """
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise InputError(f"count = {count!r}: give a whole number of modes, at least one.")
        refuse_changed(self._compiled.files)
        compiled = self._at(numbers).analysed_by("static")
        found = campbell_of(compiled.primal, speeds, count, progress)

        def enriched() -> dict[str, float]:
            return _named_by_speed(campbell_of(compiled.enriched().primal, speeds, count))

        about_bases = cautions_of_frozen(frequency_errors(compiled.scene, _named_by_speed(found), enriched))
        return found._replace(verdict=Verdict.of([*about_bases, *found.verdict.warnings]))

    def map(
        self,
        designs: Iterable[Mapping[str, float]],
        analysis: str = "transient",
        *,
        gradients: bool | str = False,
        processes: int = 1,
        threads: int = 1,
        judged: bool | str = True,
        progress: Progress | None = None,
    ) -> list[Outcome]:
        """Analyse many designs; a failure is data with its reason.

        Parameters
        ----------
        designs
            Numbers of each design, see `at`.
        analysis
            "transient" (or "simulate"), or "static" (or "statics").
        gradients
            As of `simulate`.
        processes
            How many designs are analysed at once, each in a process of its own; a script that asks for more than one needs
            `if __name__ == "__main__":`.
        threads
            How many are analysed at once in this process instead, with the scene compiled once for all. While one design is in the steps of
            its motion, another one is prepared or looked at; so two threads pay where motions are long, and processes where they are short.
            The numbers are the same to the last bit.
        judged
            Whether every outcome has a verdict. It is measured, at the price of several more runs, at designs that are far from each
            other, or close to the limit of a check, and carried from there to those whose answers and states differ by a few percent;
            a remark says so. With "each" it is measured at all designs.
        progress
            Called with the designs done and the designs in all.

        Returns
        -------
        outcomes
            In the order of the designs.

        Raises
        ------
        InputError
            There is no such analysis or method, or `judged` is another word; or both processes and threads are asked for.
        """
        kind = kind_of(analysis)
        designs = designs if isinstance(designs, Mapping | str) else list(designs)
        if isinstance(designs, Mapping | str) or not all(isinstance(each, Mapping) for each in designs):
            raise InputError('designs are a list of numbers by name, as in [{"t_w": 1.5}, {"t_w": 1.6}].')
        executor = Executor(processes, threads)
        check_method(gradients)
        if not isinstance(judged, bool) and judged != "each":
            raise InputError(f'judged = {judged!r}: write True, False, or "each" to measure the verdict on every design.')
        return outcomes(self._compiled, list(designs), kind, gradients, judged, executor, progress)

    def run(
        self,
        analysis: Kind,
        numbers: Mapping[str, float] | None = None,
        *,
        gradients: bool | str = False,
        start: Run | None = None,
        progress: Progress | None = None,
        timed: bool = False,
        keep_states: bool = False,
    ) -> Run:
        """`simulate` or `statics`, by a word.

        Parameters
        ----------
        analysis
            "transient" or "static".
        numbers, gradients, start, progress, timed
            As of `simulate`.
        keep_states
            Whether `gradients="auto"` shall provide derivatives of all states too.

        Returns
        -------
        run
            As of `simulate`.

        Raises
        ------
        InputError
            There is no such analysis; and all that `simulate` and `statics` raise.
        """
        check_kind(analysis)
        return analysed(self._at(numbers), analysis, gradients, start, progress, timed, keep_states)

    def _at(self, numbers: Mapping[str, float] | None) -> Compiled:
        """Compiled scene at other numbers, or at its own."""
        return self._compiled if numbers is None else self.at(numbers)._compiled

    def __reduce__(self) -> tuple[Callable[..., Model], tuple[Scene, tuple[str, ...]]]:
        return compile_model, (self.scene, self._compiled.names)

    def __repr__(self) -> str:
        variables = ", ".join(f"{name} = {value:g}" for name, value in self.variables.items())
        return f"<Model: {len(self.scene.bodies)} bodies, {len(self.scene.joints)} joints; variables: {variables or 'none'}>"


def kind_of(analysis: str) -> Kind:
    """Kind of an analysis from its name, or from the name of the method that does it.

    Raises
    ------
    InputError
        There is no such analysis.
    """
    found = (
        {"simulate": "transient", "statics": "static"}.get(analysis, analysis) if isinstance(analysis, str) else repr(analysis)
    )
    check_kind(found)
    return "static" if found == "static" else "transient"


def _without_responses(state: Solution) -> Solution:
    """State of a scene without its responses, whose doubts do not apply to the modes about it."""
    scene = state.system.scene.model_copy(update={"responses": {}})
    return replace(state, system=replace(state.system, scene=scene))


def _named(frequencies: np.ndarray) -> dict[str, float]:
    """Frequencies by the names that messages give them."""
    return {f"mode {k + 1}": float(each) for k, each in enumerate(frequencies)}


def _named_by_speed(found: Campbell) -> dict[str, float]:
    """Frequencies at several speeds of a spin, by the names that messages give them."""
    rows = zip(found.speeds, found.frequencies, strict=True)
    return {f"frequency {k + 1} at {speed:g} rad/time": float(each) for speed, row in rows for k, each in enumerate(row)}


def _floats(scene: Scene) -> bool:
    """Whether no joint holds a body and only its weight acts: its only equilibrium are the given positions, falling."""
    weight_alone = all(isinstance(load, UniformGravity) for load in scene.loads.values())
    return weight_alone and not scene.joints and all(body.has_frame for body in scene.bodies.values())
